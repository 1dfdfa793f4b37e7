"""The network of a machine as its core holds it, in the form that robot.toml names."""

from pathlib import Path

from gravcomp.core import lean
from gravcomp.core.formats import FixedNetwork, quantise
from gravcomp.core.output_scale import rescaled
from gravcomp.errors import InputError
from gravcomp.network.weights import Network
from gravcomp.robot.machine import PAPER, ROBOT_TOML, SERIAL, Machine


def quantised(
    machine: Machine, network: Network, folder: Path | str = "weights", formats: FixedNetwork | None = None
) -> FixedNetwork:
    """Formats and constants of the hardware; folder and formats as of ``quantise``, which raises InputError.

    So does this when formats are those of another form, or of the serial one, which loads nothing.
    """
    form = machine.form
    if formats and (formats.form != form or form == SERIAL):
        where = f"{Path(folder) / ROBOT_TOML}: [network] form = {form!r}"
        if formats.is_serial:
            raise InputError(f"{where}: the serial form of the core loads no image; write its ROM anew (gravcomp rom)")
        raise InputError(f"{where}, but the core was built with {formats.form!r}; give that")
    if form == PAPER:
        return quantise(rescaled(network, formats) if formats else network, machine.drive, folder, formats)
    q_m = machine.robot.workspace(lean.N_POSES, lean.SEED)
    serial_bits = lean.SERIAL_BITS if form == SERIAL else None
    return lean.lean_network(network, machine.drive, q_m, folder, formats, serial_bits)
