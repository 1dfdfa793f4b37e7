"""Print the core beside da4ml and NNgen: the same network, the same place and route; peers.md and its picture.

Placements that build/peers holds are not made again.
"""

from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp_lab.pages import renew
from gravcomp_lab.peers import report
from gravcomp_lab.peers.claims import claims
from gravcomp_lab.peers.design import normalised_inputs
from gravcomp_lab.peers.measure import measure
from gravcomp_lab.peers.ours import core_error, core_rows
from gravcomp_lab.simulated.pictures import save_figure
from gravcomp_lab.synthesis.survey import SEEDS, SPEEDS

N_POSES, SEED = 2000, 51
# Folder, activation, adders between registers: the quickest answer, the highest clock, and no multiplier.
DA4ML_BUILDS = (
    ("da4ml-quadratic-5", "quadratic", 5),
    ("da4ml-quadratic-1", "quadratic", 1),
    ("da4ml-hard-tanh-2", "hard tanh", 2),
)


def add_arguments(parser):
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="weights folder")
    parser.add_argument(
        "--build", type=Path, default=Path("build"), help="folder of gravcomp-lab synth and for new files"
    )
    parser.add_argument("--docs", type=Path, help="folder whose peers.md and picture are to be renewed")
    parser.add_argument("--speeds", type=int, nargs="+", default=list(SPEEDS), choices=[6, 7, 8], help="speed grades")
    parser.add_argument("--seeds", type=int, default=len(SEEDS), help="placements per design and speed grade")


def run(arguments):
    try:
        from gravcomp_lab.peers import da4ml_peer, nngen_peer
    except ImportError as error:
        raise InputError(f"{error.name}: not installed; start `make peers`") from error
    ours = core_rows(arguments.build, core_error(arguments.weights, N_POSES, SEED))
    network = load_network(arguments.weights)
    x, folder = normalised_inputs(network, load_machine(arguments.weights), N_POSES, SEED), arguments.build / "peers"
    designs = [nngen_peer.generate(network, x, folder / "nngen")]
    designs += [
        da4ml_peer.generate(network, x, folder / name, activation=activation, cutoff=cutoff)
        for name, activation, cutoff in DA4ML_BUILDS
    ]
    seeds = range(1, arguments.seeds + 1)
    with tqdm(total=len(designs) * len(arguments.speeds) * len(seeds), desc="placements", disable=None) as bar:
        peers = [measure(design, arguments.speeds, seeds, bar.update) for design in designs]
    text = "\n".join([report.table([*ours.values(), *peers]), "", report.claims_table(claims(ours, peers))])
    print(text)
    if arguments.docs:
        renew(arguments.docs / "peers.md", "peers", text)
        save_figure(report.picture(list(ours.values()), peers), arguments.docs / "figures" / "peers.png")
