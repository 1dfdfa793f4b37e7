"""The constants of the design into which faults are injected, and those loaded into it: no part of it is idle."""

from dataclasses import replace
from pathlib import Path

from gravcomp.core.folder import load_folder, save_folder
from gravcomp.core.image import Image, load_image
from gravcomp.core.provenance import PROVENANCE_JSON
from gravcomp.core.quantised import quantised
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.files import write_atomically
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine

# Friction, friction by load and cogging on every axis, so that each part of the compensator is at work.
COMPENSATION = """\
axis,name,value
all,v_dead,2e-4
all,v_full,4e-4
all,fc_pos,1.7
all,fc_neg,1.1
all,mu,0.02
all,b_pos,31
all,b_neg,25
1,pitch,0.012
2,pitch,0.021
3,pitch,0.0077
all,a1,0.8
all,p1_rad,0.4
all,a2,0.3
"""
IMAGE_SHARE = 0.9


def make_specimen(weights: Path, folder: Path) -> tuple[Path, Image]:
    """Write the generated packages of weights with the compensator above, and weights that differ, into folder.

    Returns the folder of the packages and the image of the other weights: outputs scaled by IMAGE_SHARE.
    InputError when the weights cannot be read or held.
    """
    content = load_folder(weights)
    other = replace(content.network, output_weights=IMAGE_SHARE * content.network.output_weights)
    for name, held in (("rom", content), ("image", replace(content, network=other))):
        save_folder(folder / name, held)
        write_atomically(folder / name / PROVENANCE_JSON, (weights / PROVENANCE_JSON).read_bytes())
        write_atomically(folder / name / "compensation.csv", COMPENSATION)
    write_rom(folder / "rom", folder / "generated")
    return folder / "generated", load_image(folder / "image", folder / "rom")


def ua_per_mn(weights: Path) -> float:
    """What a mN is as a current command, uA, on the axis where it is most."""
    fixed = quantised(load_machine(weights), load_network(weights), weights)
    return float((fixed.current_scale / 2.0**fixed.current_scale_fraction).max())
