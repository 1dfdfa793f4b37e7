"""A URDF or MJCF file, read by MuJoCo for what statics need: the tree of bodies, joints, masses, loops.

Geometry isn't read: meshes need not be there. A body of an MJCF without <inertial> has the masses of its simple geoms,
as in MuJoCo; a link of a URDF without <inertial> has none. Inertias are read for the virtual prototype alone.
"""

import math
import re
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from gravcomp.errors import InputError, optional

# Below what statics see; bodies without mass would not compile.
MASSLESS_KG = 1e-12
_NO_NUMBERS, _NAMES = ("nan", "inf", "infinity"), ("name", "class", "childclass", "file", "mesh", "link")
_ROOTS = {"robot": (".urdf", ".xml"), "mujoco": (".xml",)}  # of a URDF and an MJCF, and how their files' names end
_XACRO = re.compile(r"^\{https?://(www\.)?ros\.org/(wiki/)?xacro\}")
_MASS_IN_GEOMETRY = ("MESH", "HFIELD", "SDF")


def engine():
    """The module mujoco, an extra. Raises InputError where it is not installed."""
    return optional("mujoco", "mujoco", 'a robot of kind = "mujoco"')


def compile_model(path: Path):
    """The mujoco.MjModel of a file, for statics. Raises InputError naming the file, and body or line."""
    return compiled(model_spec(path, with_inertia=False), path)


def model_spec(path: Path, *, with_inertia: bool):
    """The mujoco.MjSpec of a file without its geometry, with its bodies' inertias or not. Raises InputError."""
    mujoco = engine()
    _check_kind(path)
    mujoco.set_mju_user_warning(lambda message: None)  # or the engine leaves a log file
    with _told(path):
        spec = mujoco.MjSpec.from_file(str(path))
        _check_numbers(path)
        _check_links(path)
        _check_mimics(path)
        _check_limits(spec, path)
        _leave_mechanics(spec, path, mujoco, with_inertia)
    return spec


def compiled(spec, path: Path):
    """The mujoco.MjModel of a spec read from path. Raises InputError."""
    with _told(path):
        model = spec.compile()
    _check_springs(path, model, engine())
    return model


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """What MuJoCo says of a file, in one line."""
    try:
        yield
    except InputError:
        raise
    except (ValueError, UnicodeDecodeError) as error:
        message = " ".join(str(error).split())
        raise InputError(f"{path}: not a URDF or MJCF that MuJoCo reads ({message}); correct it") from error


def sources(path: Path) -> dict[str, bytes]:
    """The file and those that it includes, content by name relative to its folder. Raises InputError."""
    found, waiting = {}, [path]
    while waiting:
        file = waiting.pop()
        name = file.relative_to(path.parent).as_posix()
        if name in found:
            continue
        try:
            found[name] = file.read_bytes()
            _check_encoding(file, found[name])
            included = [element.get("file", "") for element in ElementTree.fromstring(found[name]).iter("include")]
        except (OSError, ElementTree.ParseError) as error:
            raise InputError(f"{file}: cannot be read ({error}); correct or mend it") from error
        waiting += [_beside(path, name) for name in included]
    return found


def _beside(path: Path, name: str) -> Path:
    """A file that path includes: MuJoCo looks for it from the folder of the outermost file."""
    file = path.parent / name
    if not file.resolve().is_relative_to(path.parent.resolve()):
        raise InputError(f"{path}: includes {name}, outside its folder; put it beside, a machine folder is whole")
    return file


def _check_kind(path: Path) -> None:
    """What MuJoCo would misread, or refuse without saying what to do."""
    if not path.is_file():
        missing = "not a file" if path.exists() else "not found"
        raise InputError(f"{path}: {missing}; put the URDF or MJCF there, or correct its name")
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise InputError(f"{path}: not a URDF or MJCF: no XML ({error}); correct it") from error
    if _is_xacro(root):
        made = path.name.removesuffix(".xacro").removesuffix(".urdf") + ".made.urdf"
        how = f"xacro {shlex.quote(str(path))} > {shlex.quote(made)}"
        raise InputError(f"{path}: a source for xacro; `{how}` makes the URDF, give that")
    if root.tag not in _ROOTS:
        raise InputError(
            f"{path}: begins with <{root.tag}>, not with <robot> of a URDF or <mujoco> of an MJCF; give one"
        )
    if path.suffix not in _ROOTS[root.tag]:
        raise InputError(
            f"{path}: MuJoCo knows files by the end of their name; copy it to {path.stem}{_ROOTS[root.tag][0]}"
        )


def _is_xacro(root: ElementTree.Element) -> bool:
    """Whether macros are left in it; the name space alone often stays behind in a finished URDF."""
    return any(
        _XACRO.search(element.tag) or any("${" in value for value in element.attrib.values()) for element in root.iter()
    )


def _check_encoding(file: Path, content: bytes) -> None:
    """MuJoCo takes names for UTF-8, whatever the XML declares."""
    try:
        content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{file}: line {line} is not UTF-8, which MuJoCo takes it for; save the file as UTF-8"
        ) from error


def _check_links(path: Path) -> None:
    """MuJoCo fixes a link of a URDF that hangs on no joint to the world, and what it weighs is lost to the robot."""
    root = ElementTree.parse(path).getroot()
    links = root.findall("link") if root.tag == "robot" else []
    children = {child.get("link") for child in root.findall("joint/child")}
    roots = [link.get("name") for link in links if link.get("name") not in children]
    if len(roots) > 1:
        raise InputError(
            f"{path}: links {', '.join(map(repr, roots))} hang on no joint, and a URDF has one such link, its base; "
            "give the others their joints, or take them out"
        )


def _check_mimics(path: Path) -> None:
    """MuJoCo leaves a <mimic> of a joint that is not there out, and the follower goes its own way."""
    root = ElementTree.parse(path).getroot()
    joints = root.findall("joint") if root.tag == "robot" else []
    names = {joint.get("name") for joint in joints if joint.get("type") in ("revolute", "continuous", "prismatic")}
    for joint in joints:
        mimic = joint.find("mimic")
        if mimic is not None and mimic.get("joint") not in names:
            raise InputError(
                f"{path}: joint {joint.get('name')!r} mimics {mimic.get('joint')!r}, which is no joint that moves; "
                "correct its name"
            )


def _check_limits(spec, path: Path) -> None:
    """MuJoCo takes a range whose ends are exchanged for none."""
    for joint in spec.joints:
        low, high = joint.range
        if low > high:
            raise InputError(
                f"{path}: joint {joint.name!r}: its range {low:g} .. {high:g} ends before it begins; correct it"
            )


def _leave_mechanics(spec, path: Path, mujoco, with_inertia: bool) -> None:
    """Take away all that mechanics don't need, so that nothing of it can fail to compile."""
    is_urdf = _root_tag(path) == "robot"
    from_geoms = spec.compiler.inertiafromgeom == mujoco.mjtInertiaFromGeom.mjINERTIAFROMGEOM_TRUE
    for body in spec.bodies:
        _check_mass(path, "body", body.name, body.mass)
        if body.explicitinertial and not from_geoms and not with_inertia:
            body.fullinertia, body.inertia = [math.nan] * 6, [1.0] * 3
        has_inertia = is_urdf or body.name == "world" or (body.explicitinertial and not from_geoms)
        for geom in list(body.geoms):
            if not has_inertia:
                _check_geom(path, body, geom)
            if has_inertia or _is_mesh(geom):
                spec.delete(geom)
    for kind in ("meshes", "hfields", "skins", "flexes", "textures", "materials", "sensors", "pairs", "excludes"):
        for item in list(getattr(spec, kind)):
            spec.delete(item)
    spec.compiler.fusestatic = False  # keeps the names of links on fixed joints
    spec.compiler.balanceinertia = True
    spec.compiler.boundmass = spec.compiler.boundinertia = MASSLESS_KG


def _check_numbers(path: Path) -> None:
    """MuJoCo takes a nan for what it may choose itself."""
    for file in sources(path):
        for element in ElementTree.parse(path.parent / file).iter():
            for key, value in element.attrib.items():
                if key not in _NAMES and any(word.lower().strip("+-") in _NO_NUMBERS for word in value.split()):
                    raise InputError(
                        f'{path.parent / file}: <{element.tag}> {key}="{value}" is not a number; correct it'
                    )


def _check_springs(path: Path, model, mujoco) -> None:
    is_simple = np.isin(model.jnt_type, [mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE])
    is_odd = (model.jnt_stiffness > 0) & ~is_simple | model.jnt_stiffnesspoly.any(axis=1)
    for joint in np.flatnonzero(is_odd):
        raise InputError(
            f"{path}: joint {model.joint(joint).name!r}: only linear springs of hinges and slides are held"
        )
    if (model.tendon_stiffness > 0).any():
        raise InputError(f"{path}: springs of tendons are not held; give joints a stiffness instead")


def _root_tag(path: Path) -> str:
    return ElementTree.parse(path).getroot().tag


def _is_mesh(geom) -> bool:
    return geom.type.name.rpartition("_")[2] in _MASS_IN_GEOMETRY


def _check_geom(path: Path, body, geom) -> None:
    """A geom that gives its body mass must have a shape that is read, and no negative mass."""
    _check_mass(path, "geom of body", body.name, geom.mass)
    _check_mass(path, "geom (density) of body", body.name, geom.density)
    is_weightless = geom.mass == 0 or (math.isnan(geom.mass) and geom.density == 0)
    if _is_mesh(geom) and not is_weightless:
        raise InputError(
            f"{path}: body {body.name!r} has its mass from a mesh, and meshes are not read; give it an <inertial>"
        )


def _check_mass(path: Path, what: str, name: str, mass_kg: float) -> None:
    if mass_kg < 0 or math.isinf(mass_kg):
        raise InputError(f"{path}: {what} {name!r} has mass {mass_kg:g} kg; give a finite one, zero or more")
