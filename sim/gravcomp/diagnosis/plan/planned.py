"""From a report to a plan, and the plan as CSV and words."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.effects import NAMES, effect_named
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.plan.plan import ENOUGH, Plan, Reach, Rival, correlated, rivals, without_identities
from gravcomp.diagnosis.report.summary import joined, plain
from gravcomp.diagnosis.samples import sensors
from gravcomp.errors import InputError
from gravcomp.logs.measurement import Measurement


def of_report(data: Measurement, model: Model, path: Path) -> tuple[Measurement, list[Rival], np.ndarray]:
    """The log as a right sensor would have written it, the rivals that the report left open, and the noise (k,).

    Raises InputError where the file is no report of this log.
    """
    effects, alternatives, noise = _read(path, data.n_axes)
    model, _ = model.applicable_to(data)
    data = sensors.check(model.corrected(data)).data
    for name, parameters in effects:
        data = effect_named(name).corrected(data, parameters)
    residual = data.force - data.nominal - model.predict(data)
    of_forces = [(name, own) for name, own in effects if effect_named(name).predict(data, own).any()]
    after = residual - sum((effect_named(name).predict(data, own) for name, own in of_forces), np.zeros(data.shape))
    noise = correlated(noise, after)
    open_sets = without_identities(alternatives, dict(effects))
    return data, rivals(data, residual, of_forces, open_sets, noise) if open_sets else [], noise


def reach_of(data: Measurement, low: Sequence | None, high: Sequence | None, speed: Sequence | None) -> Reach:
    """What was given, else the log's own or the machine's. Raises InputError for a wrong number of axes."""
    own = Reach.of(data)
    given = {name: np.array(values) for name, values in (("low", low), ("high", high), ("speed", speed)) if values}
    for name, values in given.items():
        if values.shape != (data.n_axes,):
            raise InputError(f"--{name}: {len(values)} values for {data.n_axes} axes; give one per axis")
    reach = replace(own, **given)
    if (reach.low > reach.high).any() or (reach.speed < 0).any():
        raise InputError("--low, --high, --speed: low is above high, or a speed is negative; correct them")
    return reach


def plan_csv(found: Plan, reason: str) -> str:
    """Rows in the order in which they are to be measured: poses and speeds of approach, or the path of a motion."""
    rows, axes = found.rows, range(found.rows.n_axes)
    units = rows.position_units
    first = ("t_s", rows.t_s - rows.t_s[0]) if found.is_motion else ("hold", 1 + np.arange(len(rows.t_s)))
    columns = [first, *((f"q{i + 1}_{units[i]}", rows.q[:, i]) for i in axes)]
    if rows.v is not None:
        columns += [(f"v{i + 1}_{units[i]}ps", rows.v[:, i]) for i in axes]
    names, values = zip(*columns, strict=True)
    lines = [",".join(f"{x:.7g}" for x in row) for row in zip(*values, strict=True)]
    return "\n".join([f"# {reason}", ",".join(names), *lines]) + "\n"


def words(found: Plan, noise: np.ndarray) -> list[str]:
    """Why this measurement, in a line; then a line on each pair that none tells apart."""
    out = []
    if found.rows is not None:
        n, names = len(found.rows.t_s), [joined([plain(name) for name in rival.key]) for rival in found.worst]
        what = f"a motion of {n} rows" if found.is_motion else f"{n} holds, half of them as in the log"
        share = np.sqrt(found.evidence / (n * found.rows.n_axes))
        enough = "" if found.is_enough else f", less than the {ENOUGH:g} that would be sure: give more reach or speed"
        out.append(f"{what}: {names[0]} and {names[1]} differ there by {share:.2g} times the noise RMS at least, "
                   f"whatever their parameters; expected evidence {found.evidence:.0f}{enough}")  # fmt: skip
    return out + [f"no measurement within this reach tells {a} from {b}; {_remedy(a, b)}" for a, b in found.same]


def _remedy(a: str, b: str) -> str:
    names = {*a.split(" and "), *b.split(" and ")}
    known = [effect.remedy for effect in (effect_named(name) for name in sorted(names)) if effect.remedy]
    return known[0] if known else "give more reach or speed by --low, --high, --speed"


def _read(path: Path, n_axes: int) -> tuple[list[tuple[str, dict]], list[list[str]], np.ndarray]:
    """Effects with their parameters, alternatives and noise (k,) of a report.json."""
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        effects = [(entry["name"], _parameters(entry["params"])) for entry in content["effects"]]
        alternatives = [list(names) for names in content["alternatives"]]
        noise = np.array([axis["noise"] for axis in content["by_axis"]], dtype=float)
        unknown = {name for names in [*alternatives, [name for name, _ in effects]] for name in names} - {*NAMES}
        if unknown or noise.shape != (n_axes,):
            raise ValueError(f"effects {sorted(unknown)} are not known" if unknown else f"{len(noise)} axes")
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise InputError(f"{path}: no report of this log ({error}); run gravcomp diagnose on it again") from error
    return effects, alternatives, noise


def _parameters(given: Mapping[str, float]) -> dict[Parameter, float]:
    return {Parameter.parse(name): float(value) for name, value in given.items()}
