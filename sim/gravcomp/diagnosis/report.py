"""report.json (schema 1) and the before/after table."""

import json

import numpy as np

from gravcomp.diagnosis.diagnosis import Diagnosis


def errors(error: np.ndarray, force: np.ndarray) -> dict[str, float]:
    """RMS and maximum over samples and axes; 100 |E|/|F_exp| per sample, average and maximum. error, force (m, k)."""
    size = np.linalg.norm(force, axis=1)
    percent = 100.0 * np.linalg.norm(error, axis=1)[size > 0] / size[size > 0]
    return {
        "rms_n": float(np.sqrt(np.mean(error**2))),
        "max_n": float(np.abs(error).max()),
        "ave_pct": float(percent.mean()) if percent.size else 0.0,
        "max_pct": float(percent.max()) if percent.size else 0.0,
    }


def relative_percent(error: np.ndarray, force: np.ndarray) -> float:
    """100 norm(error)/norm(force), as identification papers give it."""
    return float(100.0 * np.linalg.norm(error) / max(np.linalg.norm(force), 1e-300))


def report(d: Diagnosis) -> dict:
    """The report as a dictionary, schema 1."""
    test, force = d.is_test & ~d.left_out.any(axis=1), d.data.force
    return {
        "schema": 1,
        "verdict": d.verdict,
        "effects": [
            {"name": entry.name, "params": entry.parameters,
             "ci95": {name: list(interval) for name, interval in entry.intervals.items()},
             "p_value": entry.p_value, "share": d.shares[entry.name]}
            for entry in d.fit.effects
        ],
        "alternatives": _unique(d.alternatives),
        "drivers": d.drivers,
        "before": errors(d.before[test], force[test]),
        "after": errors(d.after[test], force[test]),
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
    }  # fmt: skip


def _not_judged(d: Diagnosis) -> dict:
    """Samples at reversals, where friction may hold any force up to its level, and what is left of them."""
    at = d.data.is_reversing & ~d.left_out
    return {
        "samples": int(np.count_nonzero(at)),
        "rms_n": float(np.sqrt(np.mean(d.after[at] ** 2))) if at.any() else 0.0,
    }


def report_json(d: Diagnosis) -> str:
    return json.dumps(report(d), indent=2, allow_nan=False) + "\n"


def words(content: dict) -> list[str]:
    """Notes on the log, what was left out, what was not testable and why; a line each."""
    out = [f"note: {note}" for note in content["notes"]]
    left_out = content["left_out"]
    if any(left_out.values()):
        out.append(
            f"left out: {left_out['gross_errors']} gross errors, {left_out['missing_values']} rows without a value"
        )
    unit, still = content["unit"], content["not_judged"]
    if still["samples"]:
        out.append(f"not judged: {still['samples']} samples at reversals, where friction may hold any force up to its "
                   f"level; {still['rms_n']:.3g} {unit} RMS left there")  # fmt: skip
    if not content["noise_model_free_is_sure"]:
        out.append("the noise is the best there is: the log has neither a motion, repeats nor near neighbours; hold "
                   "some poses twice")  # fmt: skip
    by_reason: dict[str, list[str]] = {}
    for name, why in content["untestable"].items():
        by_reason.setdefault(why, []).append(name)
    return out + [f"not testable: {', '.join(names)} ({why})" for why, names in by_reason.items()]


def table(content: dict) -> str:
    """Before and after, as text."""
    unit = content["unit"]
    lines = [f"held out: {content['n_test']} of {content['n_train'] + content['n_test']} samples",
             f"{'':8}{'RMS ' + unit:>12}{'max ' + unit:>12}{'ave %':>10}{'max %':>10}"]  # fmt: skip
    for name in ("before", "after"):
        e = content[name]
        lines.append(f"{name:8}{e['rms_n']:12.4g}{e['max_n']:12.4g}{e['ave_pct']:10.3g}{e['max_pct']:10.3g}")
    free = f"{content['noise_model_free_n']:.4g} without a model, from {content['noise_model_free_from']}"
    lines.append(f"{'noise':8}{content['noise_floor_n']:12.4g} of the fit, {free}")
    lines.append(f"left of what is judged: {content['remainder_over_noise']:.3g} times that noise")
    return "\n".join(lines)


def _unique(sets: list[list[str]]) -> list[list[str]]:
    merged: dict[str, list[str]] = {}
    for names in sets:
        own = merged.setdefault(names[0], [names[0]])
        own.extend(name for name in names if name not in own)
    return list(merged.values())
