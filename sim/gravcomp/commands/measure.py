"""Measure the virtual prototype: a CSV of positions, velocities and currents, and its sealed answer.

The CSV tells nothing of what was put in; LOG.sealed.json does, and no diagnosis reads it.
"""

import math
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import check_file
from gravcomp.prototype import MODES


def add_arguments(parser):
    parser.add_argument(
        "--effect",
        action="append",
        metavar="NAME[:PARAM=VALUE,...]",
        help="what the model lacks; repeatable; none, random, random_unlisted, or a name: one not known lists all",
    )
    parser.add_argument("--seed", type=int, default=0, help="of poses, path, noise and random effects (default 0)")
    parser.add_argument("--out", required=True, metavar="LOG.csv", help="where to write")
    parser.add_argument("--mode", choices=MODES, default="both", help="static holds, slow motion, or both (default)")
    parser.add_argument("--points", type=int, default=3600, help="samples (default 3600; both: a quarter are holds)")
    parser.add_argument(
        "--noise", type=float, help="of the currents, N or Nm RMS (default: 0.2 %% of what each axis bears)"
    )
    parser.add_argument(
        "--speed", type=float, default=1.0, help="of the motion; 1 (default) is slow: 10 mm/s of the Sphe.I.Ro."
    )
    parser.add_argument("--temperature", action="store_true", help="log the motors' temperature too")
    parser.add_argument("--robot", required=True, metavar="FOLDER", help="machine folder, of kind spheiro or mujoco")


def run(arguments):
    import numpy as np

    from gravcomp.prototype.experiment import measure, write_measurement
    from gravcomp.prototype.imperfections import parse_effect
    from gravcomp.robot.machine import load_machine

    noise_is_wrong = arguments.noise is not None and not 0 <= arguments.noise < math.inf
    if arguments.seed < 0 or noise_is_wrong or not 0 < arguments.speed <= 100:
        raise InputError("--seed and --noise must not be negative or infinite, --speed must be in 0..100; correct them")
    check_file(Path(arguments.out))
    machine = load_machine(arguments.robot)

    def effects(engine, sizes):
        rng = np.random.default_rng([arguments.seed, 1])
        return [one for text in arguments.effect or ["none"] for one in parse_effect(text, rng, engine, sizes)]

    log = measure(
        machine,
        effects,
        arguments.points,
        arguments.seed,
        mode=arguments.mode,
        noise=arguments.noise,
        speed=arguments.speed,
    )
    facts = {name: getattr(arguments, name) for name in ("seed", "mode", "speed", "temperature")}
    sealed = write_measurement(arguments.out, log, machine, **facts)
    print(f"{arguments.out}: {arguments.points} samples, mode {arguments.mode}, seed {arguments.seed}")
    print(f"{sealed}: the answer; open it after the diagnosis")
