"""Train a network on the statics of a machine and write its machine folder.

--robot starts anew from robot.toml of a folder. --from trains the network in a folder further, whatever activation it
was trained with, to the Gamma of the hardware. --data takes poses and efforts from a CSV (q1_m or q1_rad, .., f1_n or
f1_nm) in place of the statics of robot.toml; a fifth of its rows is kept to test on. The starts run on all cores. With
--backend dask they run on the Dask cluster that DASK_SCHEDULER_ADDRESS names.
"""

import time
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.training import BACKENDS, POLISH_STEPS

# Of 50 steps each: a network of another activation starts far from where it ends.
_ROUNDS = 60


def add_arguments(parser):
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--robot", type=Path, metavar="FOLDER", help="machine folder; its robot.toml alone is read")
    source.add_argument("--from", type=Path, dest="start", metavar="FOLDER", help="machine folder to train further")
    parser.add_argument("--data", type=Path, metavar="CSV", help="poses and efforts to train on, of any model")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="machine folder to write")
    parser.add_argument("--hidden", type=int, default=20, help="hidden neurons (default %(default)s)")
    parser.add_argument("--starts", type=int, default=4, help="searches per round (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of poses and starts (default %(default)s)")
    parser.add_argument("--poses", type=int, default=3500, help="training poses (default %(default)s)")
    parser.add_argument(
        "--search", type=float, default=1.0, metavar="PART", help="of the usual draws and hops (default %(default)s)"
    )
    parser.add_argument(
        "--polish",
        type=int,
        default=POLISH_STEPS,
        metavar="STEPS",
        help="of the best start, at most (default %(default)s)",
    )
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="of joblib (default %(default)s)")


def run(arguments):
    from gravcomp.core.compensation import load_compensation
    from gravcomp.core.folder import MachineFolder, save_folder
    from gravcomp.core.provenance import write_provenance
    from gravcomp.robot.machine import load_machine
    from gravcomp.training.samples import machine_of_samples
    from gravcomp.training.training import evaluate, training_and_test_set

    if arguments.out.exists() and not arguments.out.is_dir():
        raise InputError(f"{arguments.out}: is a file; give a folder")
    if not 0 < arguments.search <= 100:
        raise InputError(f"--search {arguments.search:g}: give more than 0, 1 for the usual search, 100 at most")
    if arguments.polish < 1:
        raise InputError(f"--polish {arguments.polish}: give 1 step or more")
    folder = arguments.robot or arguments.start
    machine = machine_of_samples(folder, arguments.data) if arguments.data else load_machine(folder)
    data, unseen = training_and_test_set(arguments.poses, machine.robot, arguments.seed)
    began = time.monotonic()
    machine, network, fit = (_trained_further if arguments.start else _trained)(arguments, machine, data)
    metrics = evaluate(network, data, unseen, machine.activation)
    save_folder(arguments.out, MachineFolder(machine, network, load_compensation(folder, machine.n_axes)))
    sources = {"poses": len(data.q), "seed": arguments.seed, "sha256": data.hash()}
    sources |= {"test_poses": len(unseen.q), "test_seed": arguments.seed + 1}
    write_provenance(arguments.out, command=_command(arguments), data=sources, metrics=metrics, machine=machine)
    print(f"{arguments.out}: seed {arguments.seed}, stopped by {fit.reason}, {time.monotonic() - began:.0f} s")
    for name, value in metrics.items():
        print(f"  {name:20} {value:.6g}")


def _trained_further(arguments, machine, data):
    """Machine, network and fit of --from: the network of its folder, to the activation of the hardware."""
    from gravcomp.core.folder import check_network
    from gravcomp.network.weights import load_network
    from gravcomp.robot.machine import HARDWARE_ACTIVATION
    from gravcomp.training.fine_tuning import retrained

    machine = machine.with_activation(HARDWARE_ACTIVATION)
    start = load_network(arguments.start)
    check_network(arguments.start, machine, start)
    return machine, *retrained(start, data, machine.drive, _ROUNDS)


def _trained(arguments, machine, data):
    """Machine, network and fit of --robot: a network from random starts."""
    from gravcomp.network.inputs import axis_of_input
    from gravcomp.training.training import effort_of_size, train

    n_inputs = len(axis_of_input(machine.inputs))
    network, fit = train(
        data,
        machine,
        n_hidden=arguments.hidden,
        n_starts=arguments.starts,
        seed=arguments.seed,
        activation=machine.activation,
        backend=arguments.backend,
        polish=arguments.polish,
        effort=effort_of_size(arguments.hidden, n_inputs, machine.n_axes, arguments.search),
    )
    return machine, network, fit


def _command(arguments) -> str:
    """The command that does the same again."""
    if arguments.start:
        how = f"--from {arguments.start}"
    else:
        how = f"--robot {arguments.robot} --hidden {arguments.hidden} --starts {arguments.starts}"
        how += f" --search {arguments.search:g}" if arguments.search != 1.0 else ""
        how += f" --polish {arguments.polish}" if arguments.polish != POLISH_STEPS else ""
    how += f" --data {arguments.data}" if arguments.data else ""
    return f"gravcomp train {how} --out {arguments.out} --seed {arguments.seed} --poses {arguments.poses}"
