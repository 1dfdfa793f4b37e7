"""robot.toml from a URDF or MJCF: axes, ranges and units as the file has them, and by name what it does not tell."""

import json
import math
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from gravcomp.errors import InputError
from gravcomp.robot.machine import EFFORT_UNITS, MAX_AXES
from gravcomp.robot.mechanism.closure import driven_loops
from gravcomp.robot.mechanism.robot import UNITS, from_table, joint_limits, last_body, zero_pose
from gravcomp.robot.mechanism.source import compile_model, engine
from gravcomp.robot.mechanism.tree import Tree
from gravcomp.robot.ranges import Limits

_HEAD = """# From {file}. "#?" asks for what the file does not tell: fill it in and take "#?" away.
name = {name}
#? clock_hz =                   # of the core, Hz

[network]
activation = "gamma"

[model]
kind = "mujoco"
file = {file}
payload_body = {body}

[workspace]
kind = "box"                    # of the axes' ranges
"""
_COUNTS = {
    "m": "counts_per_m =               # encoder counts per m, after x4 decoding",
    "rad": 'counts_per_turn =            # encoder counts per turn of the joint, gear included: whole, or "a/b"',
}


_TURN = 0.999 * 2.0 * math.pi


def draft_toml(path: Path, axes: Sequence[str] = ()) -> str:
    """robot.toml of the robot in a file. axes: joints with a motor, in the core's order, where not all that can be.

    By default those with an actuator, or else all that move on their own. Raises InputError naming file and joint.
    """
    tree = Tree(compile_model(path))
    chosen = _named(tree, axes, path) if axes else _with_motor(tree, path)
    held = [k for k in _free_joints(tree, chosen, path) if k not in chosen]
    _check_names(tree, [*chosen, *held], path)
    _check(tree, chosen, path)
    body = tree.bodies[last_body(tree, tree.model.jnt_dofadr[chosen])]
    words = {"file": path.name, "name": path.stem, "body": body}
    sections = [_HEAD.format(**{key: json.dumps(text) for key, text in words.items()})]
    if held:
        lines = [f"{json.dumps(tree.joints[k])} = {float(zero_pose(tree)[tree.model.jnt_qposadr[k]])!r}" for k in held]
        sections.append("\n".join(["[model.held]                    # these stand still", *lines, ""]))
    bounded = _bounded(path)
    sections += [_axis_toml(name, joint_limits(tree, k), name in bounded) for k in chosen for name in [tree.joints[k]]]
    return "\n".join(sections)


def _check(tree: Tree, axes: list[int], path: Path) -> None:
    """What the robot would be refused for, whatever the ranges. Raises InputError."""
    entries = []
    for joint in axes:
        limits = joint_limits(tree, joint)
        ends = {} if limits.range else {"low": -1.0, "high": 1.0}
        entries.append({"joint": tree.joints[joint], **ends})
    from_table({"model": {"file": path.name}, "axis": entries}, str(path))


def _check_names(tree: Tree, joints: Sequence[int], path: Path) -> None:
    for joint in joints:
        if not tree.joints[joint]:
            body = tree.bodies[tree.model.jnt_bodyid[joint]]
            raise InputError(
                f"{path}: a joint of body {body!r} has no name; give it one, robot.toml knows joints by name"
            )


def _bounded(path: Path) -> set[str]:
    """Joints of a URDF that do not turn for ever, whether it gives their limits or not."""
    root = ElementTree.parse(path).getroot()
    return {joint.get("name") for joint in root.findall("joint") if joint.get("type") == "revolute"}


def _axis_toml(joint: str, limits: Limits, is_bounded: bool) -> str:
    lines = ["[[axis]]", f"joint = {json.dumps(joint)}"]
    if limits.range:
        lines += [f"low = {limits.range.low!r}", f"high = {limits.range.high!r}"]
        if limits.unit == "rad" and limits.range.high - limits.range.low > _TURN:
            lines.append('input = "sin_cos"               # more than a turn: efforts repeat')
    elif limits.unit == "rad" and not is_bounded:
        lines.append('input = "sin_cos"               # it turns without limit')
    else:
        lines += [f"#? low =                        # {limits.unit}: the file has no limits", "#? high ="]
    lines.append(f"#? {_COUNTS[limits.unit]}")
    lines.append(f"#? effort_per_ampere =          # {EFFORT_UNITS[limits.unit]}/A, gear included")
    lines.append("index_period = 0                # counts between index marks; 0: one mark")
    return "\n".join(lines) + "\n"


def _named(tree: Tree, names: Sequence[str], path: Path) -> list[int]:
    movable = _movable(tree)
    for name in names:
        if name not in [tree.joints[k] for k in movable]:
            known = ", ".join(tree.joints[k] for k in movable)
            raise InputError(f"{path}: joint {name!r} is not known; give one of {known}")
        if names.count(name) > 1:
            raise InputError(f"{path}: joint {name!r} is given twice; an axis has one motor")
    return _few_enough(tree, [tree.joints.index(name) for name in names], path)


def _with_motor(tree: Tree, path: Path) -> list[int]:
    """Joints with an actuator in the file; without any, all that no loop ties."""
    m = tree.model
    driven = {int(joint) for joint, kind in zip(m.actuator_trnid[:, 0], m.actuator_trntype, strict=True) if kind == 0}
    movable = _movable(tree)
    if driven & set(movable):
        return _few_enough(tree, [k for k in movable if k in driven], path)
    loose = [k for k in movable if not _is_follower(tree, k)]
    if not loose:
        raise InputError(f"{path}: no joint moves on its own; give a robot with 1 to {MAX_AXES} axes")
    loops = driven_loops(tree, m.jnt_dofadr[loose], str(path))
    if any(len(set(tree.dof_joint[loop.dofs])) > 2 for loop in loops):
        names = ", ".join(tree.joints[k] for k in movable)
        raise InputError(f"{path}: it has loops, and no actuators say which joints have motors; --axes of {names}")
    return _few_enough(tree, loose, path)


def _is_follower(tree: Tree, joint: int) -> bool:
    """Whether an equality of kind joint makes it follow another one, as a URDF's mimic does."""
    m, kind = tree.model, engine().mjtEq.mjEQ_JOINT
    return bool(((m.eq_type == kind) & (m.eq_obj1id == joint)).any())


def _free_joints(tree: Tree, axes: list[int], path: Path) -> list[int]:
    """Movable joints that no loop of the axes moves."""
    tied = {
        int(tree.dof_joint[dof])
        for loop in driven_loops(tree, tree.model.jnt_dofadr[axes], str(path))
        for dof in loop.dofs
    }
    return [k for k in _movable(tree) if k not in tied]


def _movable(tree: Tree) -> list[int]:
    return [k for k, kind in enumerate(tree.model.jnt_type) if kind in UNITS]


def _few_enough(tree: Tree, joints: list[int], path: Path) -> list[int]:
    if len(joints) > MAX_AXES:
        names = ", ".join(tree.joints[k] for k in joints)
        raise InputError(f"{path}: {len(joints)} joints move, a core has 1 to {MAX_AXES} axes; give --axes of {names}")
    return joints
