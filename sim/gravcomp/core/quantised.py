"""The network of a machine as its core holds it, in the form that robot.toml names."""

from pathlib import Path

from gravcomp.core import lean
from gravcomp.core.formats import FixedNetwork, quantise
from gravcomp.core.output_scale import rescaled
from gravcomp.errors import InputError
from gravcomp.network.weights import Network
from gravcomp.robot.machine import LEAN, ROBOT_TOML, Machine


def quantised(
    machine: Machine, network: Network, folder: Path | str = "weights", formats: FixedNetwork | None = None
) -> FixedNetwork:
    """Formats and constants of the hardware; folder and formats as of ``quantise``, which raises InputError.

    So does this when formats are those of the other form.
    """
    is_lean = machine.form == LEAN
    if formats and formats.is_lean != is_lean:
        built = "lean" if formats.is_lean else "paper"
        raise InputError(
            f"{Path(folder) / ROBOT_TOML}: [network] form = {machine.form!r}, but the core was built with {built!r}; "
            "give that"
        )
    if not is_lean:
        return quantise(rescaled(network, formats) if formats else network, machine.drive, folder, formats)
    return lean.lean_network(network, machine.drive, machine.robot.workspace(lean.N_POSES, lean.SEED), folder, formats)
