"""Files of each kind of drive. What is known of each format, and from where: docs/guide/export.md."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gravcomp.core.compensation import Compensation, load_compensation
from gravcomp.errors import InputError, optional
from gravcomp.export import tables
from gravcomp.export.motor import Motor, MotorCogging, motor_cogging
from gravcomp.robot.machine import EFFORT_UNITS, Axis, Machine, load_machine

MOTEUS_NODES, MOTEUS_LARGEST = 1024, 127  # int8 each, over one turn, linear between them
ODRIVE_NODES = 3600  # over one turn, none between them
NODES_PER_WAVE = 8  # as in the compensator's own table
AX8000_WAVES, AX8000_MAX_ORDER = 10, 200
AX8000_FIRST = 0x07  # subindex of "Coef 0 n" in 0x32CB; phi and r follow, then those of Coef 1
TF5200_ENTRIES = 20
TF5200_SPEEDS = {"m": 1e6, "rad": 1e3 * 180 / np.pi}  # um/s, 0.001 deg/s


@dataclass(frozen=True)
class Order:
    """What is to be written: constants of a machine, its motors, the top speed of each axis (or None), and amperes in
    one unit of the drive's torque."""

    compensation: Compensation
    machine: Machine
    motors: tuple[Motor | None, ...]
    speeds: tuple[float | None, ...]
    current_unit_a: float

    def axes(self, has: Callable) -> list[tuple[int, Axis]]:
        """Index and axis of those that have it."""
        return [(k, axis) for k, axis in enumerate(self.machine.axes) if has(self.compensation, k)]

    def friction(self, axis: int) -> tables.FrictionTable:
        top = tables.top_speed(self.compensation, axis, self.speeds[axis])
        return tables.friction_table(self.compensation, self.machine.drive, axis, top)

    def cogging(self, index: int, axis: Axis) -> MotorCogging:
        """Of the motor. Raises InputError where nothing tells its turn."""
        motor = self.motors[index]
        if motor is None:
            raise InputError(
                f"--turn: of axis {index + 1} is missing; give the travel per turn of each motor, m or rad"
            )
        return motor_cogging(self.compensation, index, axis, motor)


def read_order(folder: Path, turns, zeros, speeds, current_unit_a: float) -> Order:
    """From a machine folder and the values of the command line, one per axis or none. Raises InputError."""
    machine = load_machine(folder)
    compensation = load_compensation(folder, machine.n_axes)
    if compensation.is_empty:
        raise InputError(f"{folder}: its compensation.csv names no friction and no cogging; nothing to export")
    given = [_per_axis(name, values, machine) for name, values in (("turn", turns), ("zero", zeros), ("speed", speeds))]
    rotary = [2 * np.pi if unit == "rad" else None for unit in machine.position_units]
    turns = [own if turn is None else turn for own, turn in zip(rotary, given[0], strict=True)]
    motors = tuple(turn and Motor(turn, zero or 0.0) for turn, zero in zip(turns, given[1], strict=True))
    if 0.0 in turns or any(v is not None and v <= 0 for v in given[2]) or not 0 < current_unit_a < np.inf:
        raise InputError("--turn must not be 0, --speed and --current-unit must be above 0; correct them")
    return Order(compensation, machine, motors, tuple(given[2]), current_unit_a)


def _per_axis(name: str, values, machine: Machine) -> list[float | None]:
    if not values:
        return [None] * machine.n_axes
    if len(values) != machine.n_axes or not np.isfinite(values).all():
        raise InputError(f"--{name}: {len(values)} values for {machine.n_axes} axes; give one finite number per axis")
    return list(values)


def as_csv(order: Order) -> dict[str, str]:
    """cogging.csv and friction.csv of all axes."""
    files = {}
    cogging = ["axis,position,position_unit,effort,effort_unit,current_a"]
    for k, axis in order.axes(tables.has_cogging):
        table = tables.cogging_table(order.compensation, k)
        cogging += [
            f"{k + 1},{q:.9g},{axis.unit},{_efforts(f, axis)}"
            for q, f in zip(table.position, table.effort, strict=True)
        ]
    friction = ["axis,speed,speed_unit,effort,effort_unit,current_a,effort_per_load"]
    for k, axis in order.axes(tables.has_friction):
        table = order.friction(k)
        friction += [
            f"{k + 1},{v:.9g},{axis.unit}/s,{_efforts(f, axis)},{mu:.9g}"
            for v, f, mu in zip(table.speed, table.effort, table.mu, strict=True)
        ]
    for name, lines in (("cogging.csv", cogging), ("friction.csv", friction)):
        if len(lines) > 1:
            files[name] = "\n".join(lines) + "\n"
    return files


def _efforts(effort: float, axis: Axis) -> str:
    """effort, effort_unit, current_a."""
    return f"{effort:.9g},{EFFORT_UNITS[axis.unit]},{effort / axis.effort_per_ampere:.9g}"


def as_yaml(order: Order) -> dict[str, str]:
    """compensation.yaml: both tables of each axis that has them."""
    yaml = optional("yaml", "PyYAML", "this format")
    axes = []
    for k, axis in enumerate(order.machine.axes):
        entry = {"axis": k + 1, "name": axis.name, "position_unit": axis.unit, "effort_unit": EFFORT_UNITS[axis.unit],
                 "effort_per_ampere": axis.effort_per_ampere}  # fmt: skip
        if tables.has_cogging(order.compensation, k):
            table = tables.cogging_table(order.compensation, k)
            entry["cogging"] = {"pitch": table.pitch, "position": table.position.tolist(),
                                "effort": table.effort.tolist()}  # fmt: skip
        if tables.has_friction(order.compensation, k):
            table = order.friction(k)
            entry["friction"] = {"speed": table.speed.tolist(), "effort": table.effort.tolist(),
                                 "effort_per_load": table.mu.tolist()}  # fmt: skip
        axes.append(entry)
    return {"compensation.yaml": yaml.safe_dump({"machine": order.machine.name, "axes": axes}, sort_keys=False)}


def as_moteus(order: Order) -> dict[str, str]:
    """Lines of moteus_tool --write-config: q current, scale times int8."""
    files = {}
    for k, axis in order.axes(tables.has_cogging):
        cogging = order.cogging(k, axis)
        _check_nodes(k, cogging, MOTEUS_NODES)
        current_a = cogging.current_a(np.arange(MOTEUS_NODES) / MOTEUS_NODES)
        scale = np.abs(current_a).max() / MOTEUS_LARGEST
        lines = [f"conf set motor.cogging_dq_scale {scale:.9g}"]
        lines += [f"conf set motor.cogging_dq_comp.{n} {code}" for n, code in
                  enumerate(np.rint(current_a / scale).astype(int))]  # fmt: skip
        files[f"axis{k + 1}_moteus.cfg"] = "\n".join([*lines, "conf write"]) + "\n"
    return files


def as_odrive(order: Order) -> dict[str, str]:
    """The map of firmware 0.5: torque in Nm at 3600 places of a turn."""
    files = {}
    for k, axis in order.axes(tables.has_cogging):
        cogging = order.cogging(k, axis)
        _check_nodes(k, cogging, ODRIVE_NODES)
        torque_nm = cogging.torque_nm(np.arange(ODRIVE_NODES) / ODRIVE_NODES)
        rows = [f"{n},{torque:.9g}" for n, torque in enumerate(torque_nm)]
        files[f"axis{k + 1}_odrive.csv"] = "\n".join(["index,torque_nm", *rows]) + "\n"
    return files


def as_beckhoff(order: Order) -> dict[str, str]:
    """Cogging as object 0x32CB of an AX8000, friction as list frict_comp of TF5200."""
    files = {}
    for k, axis in order.axes(tables.has_cogging):
        files[f"axis{k + 1}_ax8000.csv"] = _ax8000(k, order.cogging(k, axis))
    for k, axis in order.axes(tables.has_speed_friction):
        files[f"axis{k + 1}_tf5200.txt"] = _tf5200(order, k, axis)
    return files


def _ax8000(index: int, cogging: MotorCogging) -> str:
    largest = np.sort(np.argsort(-cogging.amplitude_nm)[:AX8000_WAVES])
    if cogging.order[largest].max() > AX8000_MAX_ORDER:
        raise InputError(f"axis {index + 1}: {cogging.order[largest].max()} waves a turn of the motor, an AX8000 holds "
                         f"{AX8000_MAX_ORDER}; check --turn")  # fmt: skip
    lines, subindex = ["index,subindex,name,value,unit"], AX8000_FIRST
    for number, wave in enumerate(largest):
        phase_deg = np.degrees(cogging.phase_rad[wave]) % 360
        for name, value, unit in (("n", str(cogging.order[wave]), ""), ("phi", f"{phase_deg:.9g}", "deg"),
                                  ("r", f"{cogging.amplitude_nm[wave]:.9g}", "Nm")):  # fmt: skip
            lines.append(f"0x32CB,0x{subindex:02X},Cogging compensation Coef {number} {name},{value},{unit}")
            subindex += 1
    return "\n".join(lines) + "\n"


def _tf5200(order: Order, index: int, axis: Axis) -> str:
    """Mean of both directions: the list has one."""
    c = order.compensation
    speeds = np.geomspace(c.v_full[index], tables.top_speed(c, index, order.speeds[index]), TF5200_ENTRIES)
    columns = np.zeros((TF5200_ENTRIES, c.n_axes))
    columns[:, index] = speeds
    effort = (c.friction(columns) - c.friction(-columns))[:, index] / 2
    out = effort / axis.effort_per_ampere / order.current_unit_a
    lines = ["frict_comp.mode 3", f"frict_comp.table_entries {TF5200_ENTRIES}", "frict_comp.scaling_factor 1000"]
    for entry, (v, value) in enumerate(zip(speeds * TF5200_SPEEDS[axis.unit], out, strict=True)):
        lines += [f"frict_comp.table[{entry}].in {v:.9g}", f"frict_comp.table[{entry}].out {value:.9g}"]
    return "\n".join(lines) + "\n"


def _check_nodes(index: int, cogging: MotorCogging, nodes: int) -> None:
    if cogging.order.max() * NODES_PER_WAVE > nodes:
        raise InputError(f"axis {index + 1}: {cogging.order.max()} waves a turn of the motor, the drive's {nodes} "
                         f"nodes hold {nodes // NODES_PER_WAVE}; check --turn")  # fmt: skip


def left_out(order: Order, kind: str) -> list[str]:
    """What a format has no place for, one line each."""
    c, lines = order.compensation, []
    for k, axis in order.axes(lambda *_: True):
        unit = EFFORT_UNITS[axis.unit]
        if kind in ("moteus", "odrive") and tables.has_friction(c, k):
            lines.append(f"axis {k + 1}: friction is left out, the drive has no table of it")
        if kind == "beckhoff" and c.mu[k]:
            lines.append(f"axis {k + 1}: friction that follows the load is left out (mu = {c.mu[k]:g})")
        if kind == "beckhoff" and (c.fc_pos[k], c.b_pos[k]) != (c.fc_neg[k], c.b_neg[k]):
            lines.append(f"axis {k + 1}: the mean of both directions; Coulomb friction differs by "
                         f"{abs(c.fc_pos[k] - c.fc_neg[k]) / 2:g} {unit} either way")  # fmt: skip
        if kind == "beckhoff" and np.count_nonzero(c.amplitude[k]) > AX8000_WAVES:
            rest = np.sort(np.abs(c.amplitude[k]))[:-AX8000_WAVES].sum()
            lines.append(f"axis {k + 1}: the {AX8000_WAVES} largest harmonics; the rest is {rest:g} {unit} at most")
    return lines


KINDS = {"csv": as_csv, "yaml": as_yaml, "moteus": as_moteus, "odrive": as_odrive, "beckhoff": as_beckhoff}
