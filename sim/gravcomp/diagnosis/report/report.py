"""report.json (schema 1), and the same as text."""

import json

import numpy as np

from gravcomp.diagnosis.candidate import Parameter
from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.fit import Entry
from gravcomp.diagnosis.report.contributions import contributions, counted
from gravcomp.diagnosis.report.summary import found_sentence, next_sentence
from gravcomp.diagnosis.thresholds import JOINT_SHARE, TINY, WORST_APART, WORST_SHOWN
from gravcomp.logs.measurement import Measurement


def errors(error: np.ndarray, force: np.ndarray) -> dict[str, float]:
    """RMS and maximum over samples and axes; 100 |E|/|F_exp| per sample, average and maximum. error, force (m, k)."""
    size = np.linalg.norm(force, axis=1)
    percent = 100.0 * np.linalg.norm(error, axis=1)[size > 0] / size[size > 0]
    return {
        "rms_n": float(np.sqrt(np.mean(error**2))) if error.size else 0.0,
        "max_n": float(np.abs(error).max()) if error.size else 0.0,
        "ave_pct": float(percent.mean()) if percent.size else 0.0,
        "max_pct": float(percent.max()) if percent.size else 0.0,
    }


def relative_percent(error: np.ndarray, force: np.ndarray) -> float:
    """100 norm(error)/norm(force), as identification papers give it."""
    return float(100.0 * np.linalg.norm(error) / max(np.linalg.norm(force), TINY))


def report(d: Diagnosis) -> dict:
    """The report as a dictionary, schema 1."""
    test, force = d.is_test & ~d.left_out.any(axis=1), d.data.force
    decided = test & ~d.data.is_undecided.any(axis=1)
    alternatives, parts = _unique(d.alternatives), contributions(d)
    return {
        "schema": 1,
        "found": found_sentence(d, alternatives, parts),
        "next": next_sentence(d, alternatives, parts),
        "verdict": d.verdict,
        "effects": [_effect(d, entry) for entry in d.fit.effects],
        "alternatives": alternatives,
        "joint_share": d.shares.joint,
        "drivers": d.drivers,
        "contributions": [
            {"name": own.name, "kind": own.kind, "by_axis": own.by_axis.tolist(), "whole": own.whole} for own in parts
        ],
        "before": errors(d.before[test], force[test]),
        "after": errors(d.after[test], force[test]),
        "before_without_reversals": errors(d.before[decided], force[decided]),
        "after_without_reversals": errors(d.after[decided], force[decided]),
        "by_axis": _by_axis(d),
        "worst": _worst(d),
        "before_rel_pct": relative_percent(d.before[test], force[test]),
        "after_rel_pct": relative_percent(d.after[test], force[test]),
        "noise_floor_n": d.noise_floor,
        "noise_model_free_n": d.noise.rms,
        "noise_model_free_from": d.noise.source,
        "noise_model_free_is_sure": d.noise.is_sure,
        "remainder_over_noise": d.over_noise,
        "not_judged": _not_judged(d),
        "untestable": d.untestable,
        "left_out": {"gross_errors": int(np.count_nonzero(d.left_out)), "missing_values": d.data.n_dropped},
        "notes": list(d.notes),
        "n_train": int(np.count_nonzero(~test)),
        "n_test": int(np.count_nonzero(test)),
        "unit": d.data.unit,
    }


def _not_judged(d: Diagnosis) -> dict:
    """Samples at reversals, where friction may hold any force up to its level, and what is left of them."""
    at = d.data.is_reversing & ~d.left_out
    return {
        "samples": int(np.count_nonzero(at)),
        "rms_n": float(np.sqrt(np.mean(d.after[at] ** 2))) if at.any() else 0.0,
    }


def report_json(content: dict) -> str:
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def text(content: dict, seed: int) -> str:
    """The report for the terminal: two sentences, then what stands behind them."""
    lines = [content["found"], content["next"], f"verdict: {content['verdict']}; seed {seed}"]
    for effect in content["effects"]:
        own = dict.fromkeys(item["variable"] for item in content["drivers"] if item["of"] == effect["name"])
        follows = f", follows {', '.join(own)}" if own else ""
        lines.append(f"  {effect['name']}: {100 * effect['share']:.1f} % of the residual's variance alone{follows}")
    if abs(content["joint_share"]) >= JOINT_SHARE:
        lines.append(f"  {100 * content['joint_share']:.1f} % that several explain, each in the place of another")
    for item in content["drivers"]:
        if not item["of"]:
            lines.append(f"  axis {item['axis']} follows {item['variable']} ({100 * item['share']:.1f} %), no name")
    lines += [f"  this data cannot tell apart: {', '.join(names)}" for names in content["alternatives"]]
    lines += [f"  {line}" for line in words(content)]
    return "\n".join([*lines, table(content)])


def words(content: dict) -> list[str]:
    """Notes on the log, what was left out, what was not testable and why; a line each."""
    out = [f"note: {note}" for note in content["notes"]]
    gross, missing = content["left_out"].values()
    if gross or missing:
        out.append(f"left out: {gross} gross errors, {missing} rows without a value")
    unit, still = content["unit"], content["not_judged"]
    if still["samples"]:
        out.append(f"not judged: {still['samples']} samples at reversals, where friction may hold any force up to its "
                   f"level; {still['rms_n']:.3g} {unit} RMS left there")  # fmt: skip
    if not content["noise_model_free_is_sure"]:
        out.append("the noise is the best there is: the log has neither a motion, repeats nor near neighbours; hold "
                   "some poses twice")  # fmt: skip
    return out + [
        f"not testable: {', '.join(names)} ({why})" for why, names in by_reason(content["untestable"]).items()
    ]


def by_reason(untestable: dict[str, str]) -> dict[str, list[str]]:
    """Names of effects by the reason why this log cannot show them."""
    out: dict[str, list[str]] = {}
    for name, why in untestable.items():
        out.setdefault(why, []).append(name)
    return out


def table(content: dict) -> str:
    """Before and after, as text."""
    unit, wide = content["unit"], len("without reversals")
    lines = [f"held out: {content['n_test']} of {content['n_train'] + content['n_test']} samples",
             f"{'':{wide}}{'RMS ' + unit:>12}{'max ' + unit:>12}{'ave %':>10}{'max %':>10}"]  # fmt: skip
    for label, name in error_rows(content):
        e = content[name]
        lines.append(f"{label:{wide}}{e['rms_n']:12.4g}{e['max_n']:12.4g}{e['ave_pct']:10.3g}{e['max_pct']:10.3g}")
    free = f"{content['noise_model_free_n']:.4g} without a model, from {content['noise_model_free_from']}"
    lines.append(f"{'noise':{wide}}{content['noise_floor_n']:12.4g} of the fit, {free}")
    lines.append(f"left of what is judged: {content['remainder_over_noise']:.3g} times that noise")
    return "\n".join(lines)


def error_rows(content: dict) -> list[tuple[str, str]]:
    """Labels and keys of the rows of the table; those without reversals where the log has any."""
    rows = [("before", "before"), ("after", "after")]
    if content["before"] != content["before_without_reversals"]:
        rows += [("without reversals", "before_without_reversals"), ("", "after_without_reversals")]
    return rows


def unit_of(entry: Entry, name: Parameter, data: Measurement) -> str:
    """Unit of a parameter in this log: [q] and [f] are those of its axis, of the first where it has none."""
    units = entry.term.candidate.units
    stem = next((own for own in units if name.stem == own), None) or next(
        (own for own in sorted(units, key=len, reverse=True) if name.stem.startswith(f"{own}_")), ""
    )
    axis = name.axis or 0
    position = data.position_units[axis] if data.position_units else ""
    return units.get(stem, "").replace("[f]", data.effort_units[axis]).replace("[q]", position)


def _effect(d: Diagnosis, entry: Entry) -> dict:
    return {
        "name": entry.name,
        "params": entry.parameters,
        "units": {name: unit_of(entry, name, d.data) for name in entry.parameters},
        "ci95": {name: list(interval) for name, interval in entry.intervals.items()},
        "p_value": entry.p_value,
        "share": d.shares.unique[entry.name],
        "hardware": entry.term.candidate.hardware,
    }


def _by_axis(d: Diagnosis) -> list[dict]:
    """Held-out RMS before and after, and the model-free noise, of each axis in its unit."""
    use, out = counted(d), []
    for i, unit in enumerate(d.data.effort_units):
        before, after = (float(np.sqrt(np.mean(e[use[:, i], i] ** 2))) if use[:, i].any() else 0.0
                         for e in (d.before, d.after))  # fmt: skip
        out.append({"axis": i + 1, "unit": unit, "before": before, "after": after, "noise": float(d.noise.sigma[i])})
    return out


def _worst(d: Diagnosis) -> list[dict]:
    """Held-out samples where what is left is largest beside the noise of its axis, none twice at one place."""
    use = counted(d) & ~d.data.is_undecided
    size = np.where(use, np.abs(d.after) / np.maximum(d.noise.sigma, TINY), 0.0)
    where, out = d.data.scaled_positions, []
    for row in np.argsort(-size.max(axis=1)):
        axis = int(size[row].argmax())
        if len(out) == WORST_SHOWN or not size[row, axis]:
            break
        if all(np.abs(where[row] - where[other]).max() > WORST_APART for other, _ in out):
            out.append((int(row), axis))
    return [
        {"t_s": float(d.data.t_s[row]), "q": d.data.q[row].tolist(), "axis": axis + 1,
         "residual": float(d.after[row, axis]), "over_noise": float(size[row, axis])}
        for row, axis in out
    ]  # fmt: skip


def _unique(sets: list[list[str]]) -> list[list[str]]:
    merged: dict[str, list[str]] = {}
    for names in sets:
        own = merged.setdefault(names[0], [names[0]])
        own.extend(name for name in names if name not in own)
    return list(merged.values())
