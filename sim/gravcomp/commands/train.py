"""Train a network on the statics of a machine and write its machine folder.

--robot starts anew from robot.toml of a folder. --from trains the network in a folder further, whatever activation it
was trained with, to the Gamma of the hardware. --data takes poses and efforts from a CSV (q1_m or q1_rad, .., f1_n or
f1_nm) in place of the statics of robot.toml; a fifth of its rows is kept to test on. The starts run on all cores. With
--backend dask they run on the Dask cluster that DASK_SCHEDULER_ADDRESS names.
"""

import argparse
import time
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import check_folder
from gravcomp.training import BACKENDS, POLISH_STEPS

_NORM, _LEAST_NORM, _MOST_NORM = 16, 10, 24
# Of 50 steps each: a network of another activation starts far from where it ends.
_ROUNDS = 60


def add_arguments(parser):
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument("--robot", type=Path, metavar="FOLDER", help="machine folder; its robot.toml alone is read")
    source.add_argument("--from", type=Path, dest="start", metavar="FOLDER", help="machine folder to train further")
    parser.add_argument("--data", type=Path, metavar="CSV", help="poses and efforts to train on, of any model")
    parser.add_argument("--out", type=Path, required=True, metavar="FOLDER", help="machine folder to write")
    parser.add_argument(
        "--hidden",
        type=sizes,
        default=(20,),
        metavar="N[,N...]",
        help="hidden neurons (default 20); several: a sweep, a machine folder of each below --out",
    )
    parser.add_argument("--starts", type=int, default=4, help="searches per round (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of poses and starts (default %(default)s)")
    parser.add_argument("--poses", type=int, help="training poses (default: 3500, more where the network is large)")
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
    parser.add_argument(
        "--largest-error", type=float, metavar="E", help="train on for it, N or Nm, over the workspace and its boundary"
    )
    parser.add_argument("--norm", type=int, default=_NORM, metavar="P", help="p of that, even (default %(default)s)")
    parser.add_argument("--hops", type=int, default=100, help="neurons drawn anew for it (default %(default)s)")
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="of joblib (default %(default)s)")


def sizes(text: str) -> tuple[int, ...]:
    """Sizes of hidden layers as --hidden takes them."""
    try:
        return tuple(dict.fromkeys(int(part) for part in text.split(",")))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: give whole numbers, such as 20 or 8,12,20") from None


def run(arguments):
    from gravcomp.robot.machine import load_machine
    from gravcomp.training.samples import machine_of_samples
    from gravcomp.training.training import check_size, n_felt_inputs, poses_of_size, training_and_test_set

    _check(arguments)
    folder = arguments.robot or arguments.start
    machine = machine_of_samples(folder, arguments.data) if arguments.data else load_machine(folder)
    if arguments.poses is None:
        arguments.poses = poses_of_size(max(arguments.hidden), n_felt_inputs(machine), machine.n_axes)
    data, unseen = training_and_test_set(arguments.poses, machine.robot, arguments.seed)
    for n_hidden in arguments.hidden if arguments.robot else ():
        check_size(data, n_hidden, arguments.starts)  # of all, before the first takes its time
    if len(arguments.hidden) == 1:
        _train_one(arguments, machine, data, unseen, arguments.hidden[0], arguments.out)
        return
    from gravcomp.files import write_all_atomically
    from gravcomp.training.sweep import Size, picture, table

    found = []
    for n_hidden in arguments.hidden:
        network, metrics = _train_one(arguments, machine, data, unseen, n_hidden, arguments.out / str(n_hidden))
        found.append(Size.of(network, metrics))
    text = table(found, machine.effort_unit)
    write_all_atomically({arguments.out / "sweep.md": text, arguments.out / "sweep.png": picture(found)})
    print(text, end="")
    print(f"{arguments.out / 'sweep.png'}: the picture; take the folder that suits you")


def _check(arguments) -> None:
    """Raises InputError."""
    check_folder(arguments.out)
    if not 0 < arguments.search <= 100:
        raise InputError(f"--search {arguments.search:g}: give more than 0, 1 for the usual search, 100 at most")
    if arguments.polish < 1:
        raise InputError(f"--polish {arguments.polish}: give 1 step or more")
    if arguments.start and len(arguments.hidden) > 1:
        raise InputError("--hidden: --from keeps the neurons of its network; give --robot for a sweep")
    if arguments.largest_error is not None and not 0.0 < arguments.largest_error < float("inf"):
        raise InputError(f"--largest-error {arguments.largest_error:g}: give a number of N or Nm above 0")
    if arguments.norm % 2 or not _LEAST_NORM <= arguments.norm <= _MOST_NORM:
        raise InputError(f"--norm {arguments.norm}: give an even number from {_LEAST_NORM} to {_MOST_NORM}")
    if arguments.hops < 0:
        raise InputError(f"--hops {arguments.hops}: give 0 or more")


def _train_one(arguments, machine, data, unseen, n_hidden: int, out: Path):
    """One machine folder; its network and metrics."""
    from gravcomp.core.compensation import load_compensation
    from gravcomp.core.folder import MachineFolder, save_folder
    from gravcomp.core.provenance import write_provenance
    from gravcomp.training.largest_error import largest_error
    from gravcomp.training.levenberg_marquardt import ACTIVATIONS
    from gravcomp.training.training import evaluate

    folder, began = arguments.robot or arguments.start, time.monotonic()
    if arguments.start:
        machine, network, reason = _trained_further(arguments, machine, data)
    else:
        network, reason = _trained(arguments, machine, data, n_hidden)
    if arguments.largest_error is not None:
        network = _of_least_largest_error(arguments, machine, network)
    metrics = evaluate(network, data, unseen, machine.activation)
    activation = ACTIVATIONS[machine.activation].value
    metrics["largest"] = largest_error(network, machine.robot, arguments.seed + 1, activation)
    save_folder(out, MachineFolder(machine, network, load_compensation(folder, machine.n_axes)))
    sources = {"poses": len(data.q), "seed": arguments.seed, "sha256": data.hash()}
    sources |= {"test_poses": len(unseen.q), "test_seed": arguments.seed + 1}
    command = _command(arguments, n_hidden, out)
    write_provenance(out, command=command, data=sources, metrics=metrics, machine=machine)
    print(f"{out}: seed {arguments.seed}, stopped by {reason}, {time.monotonic() - began:.0f} s")
    for name, value in metrics.items():
        print(f"  {name:20} {value:.6g}")
    return network, metrics


def _trained_further(arguments, machine, data):
    """Machine, network and what stopped it, of --from: the network of its folder, to the activation of the hardware;
    as it is where it is trained for the largest error."""
    from gravcomp.core.folder import check_network
    from gravcomp.network.weights import load_network
    from gravcomp.robot.machine import HARDWARE_ACTIVATION
    from gravcomp.training.fine_tuning import retrained

    machine = machine.with_activation(HARDWARE_ACTIVATION)
    start = load_network(arguments.start)
    check_network(arguments.start, machine, start)
    if arguments.largest_error is not None:
        return machine, start, "its rounds"
    network, fit = retrained(start, data, machine.drive, _ROUNDS)
    return machine, network, fit.reason


def _trained(arguments, machine, data, n_hidden: int):
    """Network of --robot, from random starts, and what stopped it."""
    from gravcomp.training.training import effort_of_size, n_felt_inputs, train

    network, fit = train(
        data,
        machine,
        n_hidden=n_hidden,
        n_starts=arguments.starts,
        seed=arguments.seed,
        activation=machine.activation,
        backend=arguments.backend,
        polish=arguments.polish,
        effort=effort_of_size(n_hidden, n_felt_inputs(machine), machine.n_axes, arguments.search),
    )
    return network, fit.reason


def _of_least_largest_error(arguments, machine, network):
    from gravcomp.robot.machine import HARDWARE_ACTIVATION
    from gravcomp.training.largest_error import least_largest_error

    if machine.activation != HARDWARE_ACTIVATION:
        raise InputError(f"{machine.where}: --largest-error is for Gamma; give --from that folder first")
    return least_largest_error(
        network,
        machine.robot,
        machine.drive,
        wanted=arguments.largest_error,
        norm=arguments.norm,
        n_poses=arguments.poses,
        hops=arguments.hops,
        seed=arguments.seed,
    )


def _command(arguments, n_hidden: int, out: Path) -> str:
    """The command that does the same again."""
    if arguments.start:
        how = f"--from {arguments.start}"
    else:
        how = f"--robot {arguments.robot} --hidden {n_hidden} --starts {arguments.starts}"
        how += f" --search {arguments.search:g}" if arguments.search != 1.0 else ""
        how += f" --polish {arguments.polish}" if arguments.polish != POLISH_STEPS else ""
    if arguments.largest_error is not None:
        how += f" --largest-error {arguments.largest_error:g} --norm {arguments.norm} --hops {arguments.hops}"
    how += f" --data {arguments.data}" if arguments.data else ""
    return f"gravcomp train {how} --out {out} --seed {arguments.seed} --poses {arguments.poses}"
