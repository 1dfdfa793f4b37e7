"""A machine folder as the FPGA's core takes it: machine, network and compensation, once they are known to fit together.

One hash covers all that the ROM depends on. A network that was trained on another machine than robot.toml now
describes is refused, by the key that has changed: provenance.json holds what it was trained on.
"""

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path

from gravcomp.core.compensation import COMPENSATION_CSV, Compensation, load_compensation, save_compensation
from gravcomp.core.provenance import PROVENANCE_JSON
from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically
from gravcomp.network.weights import HIDDEN_CSV, SCALING_CSV, Network, load_network, network_bytes, save_network
from gravcomp.robot.machine import HARDWARE_ACTIVATION, ROBOT_TOML, Machine, load_machine

_RETRAIN = "train again with `gravcomp train --robot {0} --out {0}`"


@dataclass(frozen=True)
class MachineFolder:
    """What a machine folder holds, each part read and checked against the others."""

    machine: Machine
    network: Network
    compensation: Compensation


def load_folder(folder: Path | str) -> MachineFolder:
    """Read a machine folder for the hardware.

    Raises InputError when a part is missing or damaged, when the network has other axes or another activation than the
    hardware, or when robot.toml is not what the network was trained on.
    """
    folder = Path(folder)
    machine, network = load_machine(folder), load_network(folder)
    check_network(folder, machine, network)
    if machine.activation != HARDWARE_ACTIVATION:
        raise InputError(
            f"{folder / ROBOT_TOML}: [network] activation = {machine.activation!r}, but the hardware runs "
            f"{HARDWARE_ACTIVATION}; `gravcomp train --from {folder} --out NEW` trains it further to that"
        )
    _check_provenance(folder, machine)
    return MachineFolder(machine, network, load_compensation(folder, network.n_axes))


def save_folder(folder: Path | str, content: MachineFolder, comment: str = "") -> None:
    """Write robot.toml with its files, the network and, where it is not empty, compensation.csv with comment above; no
    provenance."""
    folder = Path(folder)
    write_all_atomically(content.machine.contents(folder / ROBOT_TOML))
    save_network(content.network, folder)
    if content.compensation.is_empty:
        (folder / COMPENSATION_CSV).unlink(missing_ok=True)
    else:
        save_compensation(content.compensation, folder, comment)


def folder_hash(folder: Path | str, machine: Machine) -> str:
    """SHA-256 over all that the ROM depends on: clock, axes, activation of the machine, network, compensation.csv."""
    path = Path(folder) / COMPENSATION_CSV
    digest = hashlib.sha256(machine.core_facts().encode())
    digest.update(network_bytes(folder))
    digest.update(path.read_bytes() if path.exists() else b"")
    return digest.hexdigest()


def check_network(folder: Path, machine: Machine, network: Network) -> None:
    """Raise InputError unless the network of a folder has the axes, units and inputs of its machine."""
    if network.n_axes != machine.n_axes:
        raise InputError(
            f"{folder / SCALING_CSV}: {network.n_axes} axes, but {ROBOT_TOML} has {machine.n_axes}; correct one"
        )
    for axis, (own, given) in enumerate(zip(machine.position_units, network.position_units, strict=True), start=1):
        if own != given:
            raise InputError(f"{folder / SCALING_CSV}: row {axis}: position_unit {given}, but {ROBOT_TOML} says {own}")
    for axis, (own, given) in enumerate(zip(machine.inputs, network.inputs, strict=True), start=1):
        if own != given:
            raise InputError(f"{folder / HIDDEN_CSV}: axis {axis} has columns of {given}, but {ROBOT_TOML} says {own}")


def printable_name(folder: Path | str) -> str:
    """The name of a machine folder, for a comment: in one line, and of letters that any encoding has."""
    name = Path(folder).absolute().name
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in name)


def _check_provenance(folder: Path, machine: Machine) -> None:
    path = folder / PROVENANCE_JSON
    try:
        known = dict(json.loads(path.read_text(encoding="utf-8"))["machine"]["trained_on"])
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        raise InputError(
            f"{path}: does not say what the network was trained on; `gravcomp adopt {folder}` compares it with "
            f"{ROBOT_TOML} and writes it, or {_RETRAIN.format(folder)}"
        ) from None
    # Through JSON, so that both sides are rounded alike.
    now = json.loads(json.dumps(machine.trained_on()))
    for key in sorted(known.keys() | now.keys()):
        if known.get(key) != now.get(key):
            raise InputError(
                f"{folder / ROBOT_TOML}: {key} = {now.get(key)}, but the network was trained with {known.get(key)}; "
                f"put it back, or {_RETRAIN.format(folder)}"
            )
