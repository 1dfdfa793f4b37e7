"""The kinds of robots that are installed: entry points of the group ``gravcomp.robots``."""

from importlib.metadata import entry_points

from gravcomp.errors import InputError
from gravcomp.robot.protocol import Robot

GROUP = "gravcomp.robots"


def robot_from_table(table: dict, where: str) -> Robot:
    """The robot that [model] of robot.toml names. Raises InputError when its kind is not installed, or incomplete."""
    model = table.get("model")
    if not isinstance(model, dict) or "kind" not in model:
        raise InputError(f"{where}: [model] kind is missing; give one of {', '.join(_names())}")
    found = entry_points(group=GROUP, name=str(model["kind"]))
    if not found:
        raise InputError(
            f"{where}: [model] kind = {model['kind']!r} is not installed; give one of {', '.join(_names())}"
        )
    return next(iter(found)).load()(table, where)


def _names() -> list[str]:
    return sorted({point.name for point in entry_points(group=GROUP)})
