"""Machine folders of MJCF and URDF robots, written by tests."""

from pathlib import Path

from gravcomp.robot.machine import Machine, load_machine

WEIGHTS = Path(__file__).resolve().parents[1] / "weights"
# Shipped machines that a file describes.
SHIPPED_MECHANISMS = ("slide", "arm2", "ur5", "so101", "panda", "fivebar")


def mechanism_toml(joints: dict[str, str], file: str = "robot.xml", model: str = "", kind: str = "mujoco") -> str:
    """robot.toml of axes, a line or lines more of [[axis]] by joint; the unit is told by counts_per_m in them."""
    axes = ""
    for joint, more in joints.items():
        counts = "" if "counts_per" in more else "counts_per_turn = 100000\n"
        axes += f'\n[[axis]]\njoint = "{joint}"\neffort_per_ampere = 10.0\n{counts}{more}\n'
    return (
        f'name = "mine"\nclock_hz = 40e6\n\n[network]\nactivation = "gamma"\n\n[model]\nkind = "{kind}"\n'
        f'file = "{file}"\n{model}\n{axes}'
    )


def write_mechanism(folder: Path, text: str, joints: dict[str, str], file: str = "robot.xml", model: str = "") -> Path:
    """A folder with robot.toml and its robot file, no network."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / file).write_text(text)
    (folder / "robot.toml").write_text(mechanism_toml(joints, file, model))
    return folder


def mechanism(folder: Path, text: str, joints: dict[str, str], file: str = "robot.xml", model: str = "") -> Machine:
    return load_machine(write_mechanism(folder, text, joints, file, model))


def mjcf(world: str, more: str = "") -> str:
    return f'<mujoco><compiler angle="radian"/><worldbody>{world}</worldbody>{more}</mujoco>'


def body(name: str, joint: str, mass_kg: float, centre: str = "0 0 0", pos: str = "0 0 0", inside: str = "") -> str:
    """A body of MJCF with one joint, given by its attributes."""
    return (
        f'<body name="{name}" pos="{pos}"><joint {joint}/>'
        f'<inertial pos="{centre}" mass="{mass_kg}" diaginertia="0.1 0.1 0.1"/>{inside}</body>'
    )
