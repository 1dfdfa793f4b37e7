"""Take a network that another tool trained: compare it with the statics of robot.toml, write provenance.json.

The folder is then known to belong together, until robot.toml changes.
"""

from pathlib import Path

from gravcomp.errors import InputError

_SEED = 2
# RMS error, of the RMS effort: more is another machine, another unit, or another activation than robot.toml says.
_LARGEST_SHARE = 0.05


def add_arguments(parser):
    parser.add_argument("weights", type=Path, metavar="FOLDER", help="machine folder")


def run(arguments):
    from gravcomp.core.folder import check_network
    from gravcomp.core.provenance import write_provenance
    from gravcomp.network.weights import SCALING_CSV, load_network
    from gravcomp.robot.machine import load_machine
    from gravcomp.training.training import N_TEST_POSES, evaluate, workspace_set

    folder = arguments.weights
    machine, network = load_machine(folder), load_network(folder)
    if network.position_units != machine.position_units:
        raise InputError(f"{folder / SCALING_CSV}: axes and units are not those of robot.toml; correct one of them")
    check_network(folder, machine, network)
    poses = workspace_set(N_TEST_POSES, machine.robot, _SEED)
    metrics = evaluate(network, poses, poses, machine.activation)
    share = metrics["test_rms"] / float((poses.f**2).mean() ** 0.5)
    print(f"{folder}: {metrics['test_rms']:.4g} {machine.effort_unit} RMS off its statics, {100 * share:.2f} %")
    if not share <= _LARGEST_SHARE:
        raise InputError(
            f"{folder}: {100 * share:.1f} % off the statics of robot.toml, more than {100 * _LARGEST_SHARE:.0f} %; "
            "correct activation, units or model there"
        )
    data = {"test_poses": N_TEST_POSES, "test_seed": _SEED}
    write_provenance(folder, command=f"gravcomp adopt {folder}", data=data, metrics=metrics, machine=machine)
