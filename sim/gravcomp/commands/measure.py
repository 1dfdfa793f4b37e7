"""Measure the virtual prototype: a CSV of positions, velocities and currents, and its sealed answer.

The CSV tells nothing of what was put in; LOG.sealed.json does, and no diagnosis reads it.
"""

import math

from gravcomp.errors import InputError
from gravcomp.prototype import DEFAULT_NOISE_N, MODES


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
    parser.add_argument("--noise", type=float, default=DEFAULT_NOISE_N, help="of the currents, N RMS (default 0.1)")
    parser.add_argument("--speed", type=float, default=1.0, help="of the motion; 1 (default) is 10 mm/s at most")
    parser.add_argument("--temperature", action="store_true", help="log the motors' temperature too")
    parser.add_argument("--robot", required=True, metavar="FOLDER", help="machine folder, of kind spheiro")


def run(arguments):
    import numpy as np

    from gravcomp.prototype.experiment import measure, write_measurement
    from gravcomp.prototype.imperfections import parse_effect
    from gravcomp.robot.machine import load_machine

    if arguments.seed < 0 or not 0 <= arguments.noise < math.inf or not 0 < arguments.speed <= 100:
        raise InputError("--seed and --noise must not be negative or infinite, --speed must be in 0..100; correct them")
    machine = load_machine(arguments.robot)
    rng = np.random.default_rng([arguments.seed, 1])
    effects = [effect for text in arguments.effect or ["none"] for effect in parse_effect(text, rng)]
    log = measure(
        machine,
        effects,
        arguments.points,
        arguments.seed,
        mode=arguments.mode,
        noise_n=arguments.noise,
        speed=arguments.speed,
    )
    facts = {name: getattr(arguments, name) for name in ("seed", "mode", "speed", "temperature")}
    sealed = write_measurement(arguments.out, log, effects, machine, noise_n=arguments.noise, **facts)
    print(f"{arguments.out}: {arguments.points} samples, mode {arguments.mode}, seed {arguments.seed}")
    print(f"{sealed}: the answer; open it after the diagnosis")
