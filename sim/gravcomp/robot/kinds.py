"""The kinds of robots that are installed: entry points of the group ``gravcomp.robots``."""

import sys
from functools import cache
from importlib.metadata import EntryPoints, entry_points

from gravcomp.errors import InputError
from gravcomp.robot.protocol import Robot

GROUP = "gravcomp.robots"


def robot_from_table(table: dict, where: str) -> Robot:
    """The robot that [model] of robot.toml names. Raises InputError when its kind is not installed, or incomplete."""
    model = table.get("model")
    if not isinstance(model, dict) or "kind" not in model:
        raise InputError(f"{where}: [model] kind is missing; give one of {', '.join(_names())}")
    found = _installed(tuple(sys.path)).select(name=str(model["kind"]))
    if not found:
        raise InputError(
            f"{where}: [model] kind = {model['kind']!r} is not installed; give one of {', '.join(_names())}"
        )
    return next(iter(found)).load()(table, where)


def _names() -> list[str]:
    return sorted(_installed(tuple(sys.path)).names)


@cache
def _installed(path: tuple[str, ...]) -> EntryPoints:
    """The kinds that are found on the path. All distributions are read for it, so only once for each path."""
    return entry_points(group=GROUP)
