"""Write what a diagnosis found back into the URDF or MJCF of the robot: masses, first moments, friction, damping.

MODEL.toml is what `gravcomp diagnose` wrote. The new file is read by MuJoCo again and its efforts are compared with
those of the model with what was found. What such a file has no place for is said.
"""

from pathlib import Path

from gravcomp.errors import InputError

_N_POSES, _SEED = 200, 1
_LARGEST_SHARE = 1e-6  # of the largest effort: what rounding leaves is far below


def add_arguments(parser):
    parser.add_argument(
        "model", type=Path, metavar="MODEL.toml", help="of gravcomp diagnose, its robot's file beside it"
    )
    parser.add_argument("--out", type=Path, required=True, metavar="FILE", help="URDF or MJCF to write")


def run(arguments):
    import numpy as np

    from gravcomp.diagnosis.effects import effect_named
    from gravcomp.diagnosis.model import load_model
    from gravcomp.files import write_atomically
    from gravcomp.robot.mechanics import Mechanics
    from gravcomp.robot.mechanism.corrected import corrected, expected_efforts
    from gravcomp.robot.mechanism.reading import reread
    from gravcomp.robot.mechanism.robot import Mechanism

    model = load_model(arguments.model)
    robot = model.machine.robot if model.machine else None
    if not isinstance(robot, Mechanism):
        raise InputError(f'{arguments.model}: its robot is of no file; correct works with [model] kind = "mujoco"')
    path = arguments.model.parent / model.machine.table["model"]["file"]
    found, taken, left = Mechanics(), [], [correction.name for correction, _ in model.corrections]
    for name, parameters in model.effects:
        part = effect_named(name).mechanics(robot, parameters)
        (left if part is None else taken).append(name)
        found = found if part is None else found.joined(part)
    if not taken:
        raise InputError(f"{arguments.model}: nothing in it that a URDF or MJCF can have; diagnose a log first")
    new = corrected(robot, path, found)
    again = reread(model.machine, new.text, new.gravity_mps2)
    q = robot.workspace(_N_POSES, _SEED)
    wanted = expected_efforts(robot, found)(q)
    off = float(np.abs(again.forces(q) - wanted).max())
    if not off <= _LARGEST_SHARE * np.abs(wanted).max():
        raise InputError(f"{path}: corrected, its efforts are {off:.3g} off the model; correct it by hand")
    write_atomically(arguments.out, new.text)
    print(f"{arguments.out}: with {', '.join(taken)}; {_N_POSES} poses in MuJoCo: {off:.1e} N or Nm off the model")
    for line in new.changes:
        print(f"  {line}")
    if new.gravity_mps2 is not None:
        numbers = ", ".join(f"{value:.8g}" for value in new.gravity_mps2)
        print(f"  robot.toml: [model] gravity = [{numbers}]")
    if left:
        print(f"left out, such a file has no place for: {', '.join(left)}")
