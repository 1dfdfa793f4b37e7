"""model.toml: robot.toml and the effects found so far; readable, editable, reloadable."""

import difflib
import math
import tomllib
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, Variable
from gravcomp.diagnosis.corrections import KINDS, Correction
from gravcomp.diagnosis.effects import NAMES, effect_named
from gravcomp.diagnosis.fit import Fit
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.logs.thresholds import LARGEST
from gravcomp.robot.machine import ROBOT_TOML, Machine, parse_machine

_TABLES = ("effects", "empirical")
_EFFECT_KEYS = {"name", "params"}
_EMPIRICAL_KEYS = {"axis", "kind", "variables", "by_direction", "shape", "values"}


@dataclass(frozen=True)
class Model:
    """A machine, or None where only the log's own predictions are the model; effects as (name, parameters), empirical
    corrections as (correction, values).
    """

    machine: Machine | None = None
    effects: list[tuple[str, dict[str, float]]] = field(default_factory=list)
    corrections: list[tuple[Correction, tuple[float, ...]]] = field(default_factory=list)

    @property
    def known(self) -> dict[str, dict[str, float]]:
        """By effect the sums of its parameters by name: what a change may take away."""
        total: dict[str, Counter] = {}
        for name, parameters in self.effects:
            total.setdefault(name, Counter()).update(parameters)
        return {name: dict(own) for name, own in total.items()}

    def grown(self, fit: Fit) -> "Model":
        """This model with what was fitted on top of it."""
        return replace(
            self,
            effects=self.effects + [(entry.name, dict(entry.parameters)) for entry in fit.effects],
            corrections=self.corrections + [(e.term.candidate, tuple(e.parameters.values())) for e in fit.corrections],
        )

    def corrected(self, data: Measurement) -> Measurement:
        """The log as the sensors would have written it without the known effects of sensors."""
        for name, parameters in self.effects:
            data = effect_named(name).corrected(data, parameters)
        return data

    def applicable_to(self, data: Measurement) -> tuple["Model", list[str]]:
        """The part of the model that this log has the columns for, and a line on each part that it has not.

        Raises InputError for parameters of axes that the model's own robot does not have.
        """
        effects, corrections, notes = [], [], []
        for name, parameters in self.effects:
            why = effect_named(name).unavailable(data) or _lacks(name, parameters, data)
            if why:
                notes.append(f"the model's {name} is left aside: {why}")
            else:
                effects.append((name, parameters))
        for correction, values in self.corrections:
            why = _cannot_follow(correction, data)
            if why:
                notes.append(f"the model's correction of {correction.name} is left aside: {why}")
            else:
                corrections.append((correction, values))
        return replace(self, effects=effects, corrections=corrections), notes

    def predict(self, data: Measurement) -> np.ndarray:
        """Sum of all effects and corrections, (n, k), to be added to data.nominal. Raises InputError."""
        force = np.zeros(data.shape)
        for name, parameters in self.effects:
            effect = effect_named(name)
            why = effect.unavailable(data)
            if why:
                raise InputError(f"{data.name}: the model has {name}, but {why}; remove it from the model")
            try:
                force = force + effect.predict(data, parameters)
            except (KeyError, IndexError, ValueError) as error:
                raise InputError(f"model: parameters of {name} do not fit the data ({error}); correct them") from error
        for correction, values in self.corrections:
            force[:, correction.axis] += correction.regressors(data) @ np.array(values)
        return force


def _lacks(name: str, parameters: Mapping[Parameter, float], data: Measurement) -> str:
    beyond = [key for key in parameters if key.axis is not None and key.axis >= data.n_axes]
    if beyond and data.robot is not None:
        raise InputError(
            f"model: [[effects]] {name} {beyond[0]}: the robot has axes 1..{data.n_axes}; correct the axis"
        )
    if beyond:
        return f"{beyond[0]}, and the log has axes 1..{data.n_axes}"
    if any(key.stem == "t0" for key in parameters) and data.temp_c is None:
        return "no temp_c in the log"
    return ""


def _cannot_follow(correction: Correction, data: Measurement) -> str:
    axes = [correction.axis] + [variable.axis for variable in correction.variables if variable.axis is not None]
    if max(axes) >= data.n_axes:
        if data.robot is not None:
            raise InputError(f"model: [[empirical]] {correction.name}: the robot has axes 1..{data.n_axes}; correct it")
        return f"the log has axes 1..{data.n_axes}"
    if not all(variable.is_in(data) for variable in correction.variables):
        return "the log has no such column"
    if correction.by_direction and not data.has_velocity:
        return "no velocity in the log"
    return ""


def load_model(path: Path | str) -> Model:
    """Read a model.toml, or robot.toml of a machine folder. Raises InputError naming table, key and mend."""
    path = Path(path) / ROBOT_TOML if Path(path).is_dir() else Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a machine folder or a model.toml") from error
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not valid TOML ({error}); correct that line") from error
    for name in table:
        meant = difflib.get_close_matches(name, _TABLES, cutoff=0.7)
        if meant and name not in _TABLES:
            raise InputError(f"{path}: [[{name}]] is not known; name it [[{meant[0]}]]")
    effects = [_effect(path, entry) for entry in _entries(path, table, "effects")]
    corrections = [_correction(path, entry) for entry in _entries(path, table, "empirical")]
    machine = parse_machine(text, str(path)) if table.keys() - set(_TABLES) else None
    return Model(machine, effects, corrections)


def _entries(path: Path, table: dict, name: str) -> list[dict]:
    entries = table.get(name, [])
    if not isinstance(entries, list) or not all(isinstance(entry, dict) for entry in entries):
        raise InputError(f"{path}: [{name}] is not a list of tables; write [[{name}]]")
    return entries


def _only(path: Path, where: str, entry: dict, keys: set[str]) -> None:
    for key in entry:
        if key not in keys:
            meant = difflib.get_close_matches(key, keys, 1, cutoff=0.0)
            raise InputError(f"{path}: {where} {key} is not known; name it {meant[0]}, or delete it")


def _number(path: Path, where: str, value) -> float:
    try:
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool) and abs(float(value)) < LARGEST
    except OverflowError:
        is_number = False
    if not is_number or math.isnan(value):
        shown = repr(value) if len(repr(value)) < 40 else repr(value)[:36] + "..."
        raise InputError(f"{path}: {where} = {shown} is not a finite number below {LARGEST:g}; give one")
    return float(value)


def _effect(path: Path, entry: dict) -> tuple[str, dict[Parameter, float]]:
    name, parameters = entry.get("name"), entry.get("params", {})
    if name not in NAMES:
        raise InputError(f"{path}: [[effects]] name = {name!r} is not known; use one of {', '.join(NAMES)}")
    where = f"[[effects]] {name}"
    _only(path, where, entry, _EFFECT_KEYS)
    if not isinstance(parameters, dict):
        raise InputError(f"{path}: {where} params = {parameters!r} is not a table; write [effects.params]")
    effect, out = effect_named(name), {}
    for key, value in parameters.items():
        parameter = Parameter.parse(key)
        if not effect.has(parameter):
            known = ", ".join(f"{stem}_1" if effect.per_axis else stem for stem in effect.units)
            raise InputError(f"{path}: {where} {key} is none of its parameters; they are {known}, axes from 1")
        out[parameter] = _number(path, f"{where} {key}", value)
        if parameter.stem in effect.scales and out[parameter] <= 0.0:
            raise InputError(f"{path}: {where} {key} = {value!r} is out of range; give a positive number")
    return name, out


def _correction(path: Path, entry: dict) -> tuple[Correction, tuple[float, ...]]:
    where = "[[empirical]]"
    _only(path, where, entry, _EMPIRICAL_KEYS)
    missing = sorted(_EMPIRICAL_KEYS - set(entry))
    if missing:
        raise InputError(f"{path}: {where} {missing[0]} is missing; add it, or delete the table")
    kind, axis, by_direction = entry["kind"], entry["axis"], entry["by_direction"]
    if kind not in KINDS:
        raise InputError(f"{path}: {where} kind = {kind!r} is not known; use one of {', '.join(KINDS)}")
    if isinstance(axis, bool) or not isinstance(axis, int) or axis < 1:
        raise InputError(f"{path}: {where} axis = {axis!r} is no axis; they count from 1")
    if not isinstance(by_direction, bool):
        raise InputError(
            f"{path}: {where} by_direction = {by_direction!r} is not true or false; write it without quotes"
        )
    lists = {key: entry[key] for key in ("variables", "shape", "values")}
    for key, value in lists.items():
        if not isinstance(value, list):
            raise InputError(f"{path}: {where} {key} = {value!r} is not a list; give one")
    try:
        variables = tuple(Variable.parse(str(name)) for name in lists["variables"])
    except ValueError as error:
        raise InputError(f"{path}: {where} variables: {error}") from error
    shape = tuple(_number(path, f"{where} shape", x) for x in lists["shape"])
    values = tuple(_number(path, f"{where} values", x) for x in lists["values"])
    correction = KINDS[kind](axis - 1, variables, shape, by_direction)
    wrong = correction.wrong_with(len(values))
    if wrong:
        raise InputError(f"{path}: {where} {wrong}; correct or delete it")
    return correction, values


def _nominal(text: str, table: dict) -> str:
    """The robot's part of the file: its lines as they stand where they can be told apart, else written again."""
    kept, own = [], True
    for line in text.splitlines():
        header = line.split("#")[0].strip()
        if header.startswith("["):
            own = header.strip("[] ").split(".")[0].strip() not in _TABLES
        if own:
            kept.append(line)
    robot = {name: value for name, value in table.items() if name not in _TABLES}
    lines = "\n".join(kept).strip() + "\n"
    try:
        if tomllib.loads(lines) == robot:
            return lines
    except tomllib.TOMLDecodeError:
        pass
    ordered = sorted(robot.items(), key=lambda item: isinstance(item[1], dict))  # values belong to the table above them
    return "\n".join(_table_toml(name, value) for name, value in ordered)


def _table_toml(name: str, value) -> str:
    if not isinstance(value, dict):  # [[axis]] becomes a list of inline tables
        return f"{name} = {_value_toml(value)}\n"
    return "\n".join([f"[{name}]", *(f"{key} = {_value_toml(own)}" for key, own in value.items())]) + "\n"


def _value_toml(value) -> str:
    if isinstance(value, str):
        return '"' + value.replace("\\", "\\\\").replace('"', '\\"') + '"'
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key} = {_value_toml(own)}" for key, own in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value_toml, value)) + "]"
    return str(value).lower() if isinstance(value, bool) else repr(value)


def model_toml(model: Model) -> str:
    """The text of model.toml."""
    parts = [_nominal(model.machine.text, model.machine.table).rstrip() + "\n"] if model.machine else []
    for name, parameters in model.effects:
        lines = [f"{key} = {value!r}" for key, value in parameters.items()]
        effect = effect_named(name)
        head = f"[[effects]]  # {effect.equation}; in hardware: {effect.hardware}"
        parts.append("\n".join([head, f'name = "{name}"', "[effects.params]", *lines]) + "\n")
    for c, values in model.corrections:
        names = ", ".join(f'"{name}"' for name in c.variables)
        parts.append(
            f'[[empirical]]  # no physics: a correction of axis {c.axis + 1}\naxis = {c.axis + 1}\nkind = "{c.kind}"\n'
            f"variables = [{names}]\nby_direction = {str(c.by_direction).lower()}\n"
            f"shape = {[float(x) for x in c.shape]}\nvalues = {[float(x) for x in values]}\n"
        )
    return "\n".join(parts)
