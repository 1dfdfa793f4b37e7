"""Train a network on the robot's statics and write its weights folder.

The starts run on all cores. With --backend dask they run on the Dask cluster that DASK_SCHEDULER_ADDRESS names.
"""

import time
from pathlib import Path

from gravcomp.core.provenance import write_provenance
from gravcomp.errors import InputError
from gravcomp.network.weights import save_network
from gravcomp.robot.spheiro.parameters import NOMINAL_TOML, load_parameters
from gravcomp.training.levenberg_marquardt import ACTIVATIONS
from gravcomp.training.training import BACKENDS, N_TEST_POSES, Effort, evaluate, train, workspace_set


def add_arguments(parser):
    parser.add_argument("--hidden", type=int, default=20, help="hidden neurons (default %(default)s)")
    parser.add_argument("--starts", type=int, default=4, help="searches per round (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1, help="of poses and starts (default %(default)s)")
    parser.add_argument("--poses", type=int, default=3500, help="training poses (default %(default)s)")
    parser.add_argument("--out", type=Path, default=Path("weights/spheiro"), help="folder (default %(default)s)")
    parser.add_argument("--activation", choices=sorted(ACTIVATIONS), default="gamma", help="default %(default)s")
    parser.add_argument("--backend", choices=BACKENDS, default="loky", help="of joblib (default %(default)s)")
    parser.add_argument("--robot", type=Path, default=NOMINAL_TOML, help="robot parameters")


def run(arguments):
    if arguments.out.exists() and not arguments.out.is_dir():
        raise InputError(f"{arguments.out}: is a file; give a folder")
    p = load_parameters(arguments.robot)
    data = workspace_set(arguments.poses, p, arguments.seed)
    began = time.monotonic()
    network, fit = train(
        data,
        p,
        n_hidden=arguments.hidden,
        n_starts=arguments.starts,
        seed=arguments.seed,
        activation=arguments.activation,
        backend=arguments.backend,
        effort=Effort(),
    )
    unseen = workspace_set(N_TEST_POSES, p, arguments.seed + 1)
    metrics = evaluate(network, data, unseen, arguments.activation)
    save_network(network, arguments.out)
    command = (
        f"gravcomp train --hidden {arguments.hidden} --starts {arguments.starts} --seed {arguments.seed} "
        f"--poses {arguments.poses} --activation {arguments.activation}"
    )
    sources = {"poses": arguments.poses, "seed": arguments.seed, "sha256": data.hash()}
    sources |= {"test_poses": N_TEST_POSES, "test_seed": arguments.seed + 1}
    write_provenance(arguments.out, command=command, data=sources, metrics=metrics)
    print(f"{arguments.out}: seed {arguments.seed}, stopped by {fit.reason}, {time.monotonic() - began:.0f} s")
    for name, value in metrics.items():
        print(f"  {name:20} {value:.6g}")
