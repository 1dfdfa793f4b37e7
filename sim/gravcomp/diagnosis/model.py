"""model.toml: the nominal parameters and the effects found so far; readable, editable, reloadable."""

import math
import tomllib
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from gravcomp.diagnosis.candidate import Parameter, Variable
from gravcomp.diagnosis.corrections import KINDS, Correction
from gravcomp.diagnosis.effects import NAMES, effect_named
from gravcomp.diagnosis.fit import Fit
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement
from gravcomp.robot.spheiro.parameters import NOMINAL_TOML, RobotParameters, load_parameters, parameters_from_table


@dataclass
class Model:
    """Robot parameters, effects as (name, parameters), empirical corrections as (correction, values)."""

    robot: RobotParameters = field(default_factory=load_parameters)
    nominal_toml: str = field(default_factory=lambda: NOMINAL_TOML.read_text(encoding="utf-8"))
    effects: list[tuple[str, dict[str, float]]] = field(default_factory=list)
    corrections: list[tuple[Correction, tuple[float, ...]]] = field(default_factory=list)

    def grown(self, fit: Fit) -> "Model":
        """This model with what was fitted on top of it."""
        return replace(
            self,
            effects=self.effects + [(entry.name, dict(entry.parameters)) for entry in fit.effects],
            corrections=self.corrections + [(e.term.candidate, tuple(e.parameters.values())) for e in fit.corrections],
        )

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


def load_model(path: Path | str) -> Model:
    """Read model.toml. Raises InputError naming what is wrong."""
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
        table = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read ({error}); give a model.toml") from error
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML ({error}); correct that line") from error
    effects = [_effect(path, entry) for entry in table.get("effects", [])]
    corrections = [_correction(path, entry) for entry in table.get("empirical", [])]
    nominal = text.split("\n[[", 1)[0].rstrip() + "\n"
    return Model(parameters_from_table(table, str(path)), nominal, effects, corrections)


def _effect(path: Path, entry: dict) -> tuple[str, dict[str, float]]:
    name, parameters = entry.get("name"), entry.get("params", {})
    if name not in NAMES:
        raise InputError(f"{path}: [[effects]] name = {name!r} is not known; use one of {', '.join(NAMES)}")
    for key, value in parameters.items():
        if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
            raise InputError(f"{path}: [[effects]] {name} {key} = {value!r} is not a finite number; give one")
    return name, {Parameter.parse(key): float(value) for key, value in parameters.items()}


def _correction(path: Path, entry: dict) -> tuple[Correction, tuple[float, ...]]:
    try:
        shape = tuple(float(x) for x in entry["shape"])
        names = tuple(Variable.parse(name) for name in entry["variables"])
        correction = KINDS[entry["kind"]](int(entry["axis"]) - 1, names, shape, bool(entry["by_direction"]))
        return correction, tuple(float(x) for x in entry["values"])
    except (KeyError, TypeError, ValueError) as error:
        raise InputError(f"{path}: [[empirical]] is not complete ({error}); correct or delete it") from error


def model_toml(model: Model) -> str:
    """The text of model.toml."""
    parts = [model.nominal_toml.rstrip() + "\n"]
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
