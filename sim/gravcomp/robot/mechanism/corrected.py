"""A URDF or MJCF with what was found in measured data: masses, first moments, gravity, friction, damping, springs.

The text is edited where it has to be and stays as it was elsewhere. A first moment s and a mass M more make of mass m
at r the mass m + M at (m r + s) / (m + M): efforts follow exactly. Inertias, which statics do not see, stay. A body
without mass that is fixed to another one gives its part to that one. What was found is added to the masses and springs
of the file, which the model has that the data were compared with; it takes the place of friction, damping and armature,
which that model has not.
"""

import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from gravcomp.errors import InputError
from gravcomp.robot.mechanics import Mechanics, one_spring
from gravcomp.robot.mechanism.robot import Mechanism
from gravcomp.robot.mechanism.source import compiled, engine, model_spec
from gravcomp.robot.mechanism.tree import HINGE

_RADIUS_OF_GYRATION_M = 0.01  # of a mass where there was none: statics do not see it


@dataclass(frozen=True)
class Corrected:
    """text: of the new file; changes: a line on each; gravity_mps2 (3,): if the base is tilted, for robot.toml."""

    text: str
    changes: tuple[str, ...]
    gravity_mps2: np.ndarray | None


def corrected(robot: Mechanism, path: Path, found: Mechanics) -> Corrected:
    """The file at path, which robot was read from, with what was found. Raises InputError naming file and body or joint
    where the file cannot have it.
    """
    file = _File(robot, path)
    for body, (mass_kg, moment_kgm) in _by_heavy_body(robot, found, path).items():
        file.load(body, mass_kg, moment_kgm)
    axes = robot.tree.dof_joint[robot.axes]
    joints = {"frictionloss": _by_joint(found.friction, axes), "damping": _by_joint(found.damping, axes),
              "armature": _by_joint(found.armature, axes)}  # fmt: skip
    if found.passive_friction:
        joints["frictionloss"] |= _by_joint(found.passive_friction, robot.passive_joints)
    for quantity, by_joint in joints.items():
        for joint, value in by_joint.items():
            file.set_on_joint(joint, quantity, value)
    for axis, spring in found.springs.items():
        file.add_spring(int(axes[axis]), spring)
    gravity = None
    if found.gravity_direction is not None:
        gravity = np.linalg.norm(robot.gravity_mps2) * found.gravity_direction
        file.turn_gravity(gravity)
    return Corrected(file.text(), tuple(file.changes), gravity)


def _by_joint(values, joints: np.ndarray) -> dict[int, float]:
    return {int(joints[number]): float(value) for number, value in values.items() if value}


def _by_heavy_body(robot: Mechanism, found: Mechanics, path: Path) -> dict[int, tuple[float, np.ndarray]]:
    """Mass at the origin, and first moment, to add to bodies by number, each with a mass, or to be given one."""
    tree, m, out = robot.tree, robot.tree.model, {}
    parts = [(tree.bodies.index(name) if name else robot.last_body, 0.0, s) for name, s in found.moments_kgm.items()]
    parts.append((robot.last_body, found.mass_kg, np.zeros(3)))
    for body, mass, moment in parts:
        if not mass and not np.any(moment):
            continue
        name = tree.bodies[body]
        while not tree.mass_kg[body] and not m.body_jntnum[body] and tree.parent[body]:
            turn = np.empty(9)
            engine().mju_quat2Mat(turn, m.body_quat[body])
            moment = turn.reshape(3, 3) @ moment + mass * m.body_pos[body]
            body = int(tree.parent[body])
        if tree.mass_kg[body] + mass <= 0.0:
            raise InputError(
                f"{path}: body {name!r} would have the mass {tree.mass_kg[body] + mass:.4g} kg, and a first "
                "moment needs one; give it a mass in the file, and diagnose again"
            )
        before = out.get(body, (0.0, np.zeros(3)))
        out[body] = before[0] + mass, before[1] + moment
    return out


class _File:
    """The text of a file, as a tree that keeps its comments."""

    def __init__(self, robot: Mechanism, path: Path):
        self._robot, self._path, self.changes = robot, path, []
        self._text = path.read_text(encoding="utf-8")
        builder = ElementTree.TreeBuilder(insert_comments=True)
        self._root = ElementTree.parse(path, ElementTree.XMLParser(target=builder)).getroot()
        self._is_urdf = self._root.tag == "robot"
        self._model = compiled(model_spec(path, with_inertia=True), path)  # with what defaults and geoms give

    def text(self) -> str:
        stream = io.StringIO()
        ElementTree.ElementTree(self._root).write(stream, encoding="unicode")
        return self._text[: self._text.index(f"<{self._root.tag}")] + stream.getvalue() + "\n"

    def load(self, body: int, mass_kg: float, moment_kgm: np.ndarray) -> None:
        m, name = self._model, self._robot.tree.bodies[body]
        before, centre = self._robot.tree.mass_kg[body], m.body_ipos[body]
        after = before + mass_kg
        place = (before * centre + moment_kgm) / after
        inertial = self._inertial(body, after)
        if self._is_urdf:
            inertial.find("mass").set("value", _number(after))
            _child(inertial, "origin").set("xyz", _numbers(place))
        else:
            inertial.set("mass", _number(after))
            inertial.set("pos", _numbers(place))
        self.changes.append(
            f"body {name}: mass {before:.6g} -> {after:.6g} kg, centre of mass {_short(centre)} -> {_short(place)} m"
        )

    def _inertial(self, body: int, mass_kg: float) -> ElementTree.Element:
        """<inertial> of a body, made from what its geoms give where there is none."""
        name, m = self._robot.tree.bodies[body], self._model
        element = self._named("link" if self._is_urdf else "body", name)
        compiler = self._root.find("compiler")
        if compiler is not None and compiler.get("inertiafromgeom") == "true":
            raise InputError(f'{self._path}: inertiafromgeom="true" overrules <inertial>; take it out, diagnose again')
        inertial = element.find("inertial")
        if inertial is not None:
            return inertial
        has_mass = self._robot.tree.mass_kg[body] > 0
        inertia = m.body_inertia[body] if has_mass else [mass_kg * _RADIUS_OF_GYRATION_M**2] * 3
        inertial = ElementTree.Element("inertial")
        element.insert(0, inertial)
        if self._is_urdf:
            _child(inertial, "mass")
            names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
            values = [*inertia, 0.0, 0.0, 0.0]
            _child(inertial, "inertia").attrib.update(zip(names, map(_number, values), strict=True))
        else:
            inertial.attrib.update(diaginertia=_numbers(inertia), quat=_numbers(m.body_iquat[body]))
        return inertial

    def set_on_joint(self, joint: int, quantity: str, value: float) -> None:
        """quantity: of MuJoCo's joints: frictionloss, damping, armature."""
        name, before = self._robot.tree.joints[joint], float(
            getattr(self._model, f"dof_{quantity}")[self._model.jnt_dofadr[joint]])  # fmt: skip
        if value < 0.0:
            raise InputError(
                f"{self._path}: joint {name!r} would have the {quantity} {value:.4g}; it cannot be negative"
            )
        if not self._is_urdf:
            self._named("joint", name).set(quantity, _number(value))
        elif quantity == "armature":
            raise InputError(f"{self._path}: a URDF has no armature, which joint {name!r} needs; give an MJCF")
        else:
            dynamics = _child(self._named("joint", name), "dynamics")
            dynamics.set({"frictionloss": "friction"}.get(quantity, quantity), _number(value))
        self.changes.append(f"joint {name}: {quantity} {before:.6g} -> {value:.6g}")

    def add_spring(self, joint: int, spring: tuple[float, float]) -> None:
        m, name = self._model, self._robot.tree.joints[joint]
        if self._is_urdf:
            raise InputError(f"{self._path}: a URDF has no springs, which joint {name!r} needs; give an MJCF")
        before = float(m.jnt_stiffness[joint]), float(m.qpos_spring[m.jnt_qposadr[joint]])
        stiffness, rest = one_spring(before, spring)
        if stiffness < 0.0:
            raise InputError(
                f"{self._path}: joint {name!r} would have the stiffness {stiffness:.4g}; MuJoCo takes none below zero: "
                "take the effect out of the model"
            )
        compiler = self._root.find("compiler")
        in_degrees = m.jnt_type[joint] == HINGE and (compiler is None or compiler.get("angle", "degree") == "degree")
        element = self._named("joint", name)
        element.set("stiffness", _number(stiffness))
        element.set("springref", _number(np.rad2deg(rest) if in_degrees else rest))
        self.changes.append(f"joint {name}: stiffness {before[0]:.6g} -> {stiffness:.6g}, at rest at {rest:.6g}")

    def turn_gravity(self, gravity_mps2: np.ndarray) -> None:
        if not self._is_urdf:
            _child(self._root, "option").set("gravity", _numbers(gravity_mps2))
            self.changes.append(f"gravity {_short(self._robot.gravity_mps2)} -> {_short(gravity_mps2)} m/s^2")

    def _named(self, kind: str, name: str) -> ElementTree.Element:
        # Not those that a transmission or an equality has under the same name.
        places = (
            [self._root] if self._is_urdf else [e for world in self._root.findall("worldbody") for e in world.iter()]
        )
        found = [element for place in places for element in place.findall(kind) if element.get("name") == name]
        if not found:
            raise InputError(f"{self._path}: {kind} {name!r} stands in a file that it includes; give one file")
        return found[0]


def _child(element: ElementTree.Element, tag: str) -> ElementTree.Element:
    found = element.find(tag)
    return ElementTree.SubElement(element, tag) if found is None else found


def _number(value: float) -> str:
    return repr(float(value))


def _numbers(values) -> str:
    return " ".join(map(_number, values))


def _short(values) -> str:
    return "(" + ", ".join(f"{value:.5g}" for value in values) + ")"


def expected_efforts(robot: Mechanism, found: Mechanics) -> Callable[[np.ndarray], np.ndarray]:
    """Efforts (N, n) at q (N, n) of the robot with what was found, by its own regressors."""
    turned = robot if found.gravity_direction is None else robot.with_gravity(found.gravity_direction)

    def efforts(q: np.ndarray) -> np.ndarray:
        total = turned.forces(q) + found.mass_kg * turned.payload_mass_regressor(q)
        for name, moment in found.moments_kgm.items():
            body = robot.body_names.index(name) if name else len(robot.body_names) - 1
            total += turned.moment_regressors(q)[:, :, body] @ moment
        for axis, (stiffness, rest) in found.springs.items():
            total[:, axis] += stiffness * (q[:, axis] - rest)
        return total

    return efforts
