"""Two sentences for people: what was found and how sure that is, and what to do next."""

import numpy as np

from gravcomp.diagnosis.diagnosis import Diagnosis
from gravcomp.diagnosis.fit import Entry
from gravcomp.diagnosis.report.contributions import Contribution, counted

_PLAN = "gravcomp plan"


def found_sentence(d: Diagnosis, alternatives: list[list[str]], parts: list[Contribution]) -> str:
    """What the model lacks, how much of it that explains, and how sure the names are."""
    use = counted(d)
    before, after = (float(np.sqrt(np.mean(error[use] ** 2))) for error in (d.before, d.after))
    unit = d.data.unit if len(set(d.data.effort_units)) == 1 else "N, Nm"
    if d.verdict == "nothing_missing":
        return f"The model lacks nothing that this log shows: what is left, {after:.3g} {unit} RMS, is its noise."
    if not d.fit.effects:
        what = _followed(d)
        return f"The model lacks {before:.3g} {unit} RMS, and no effect on the list explains it: {what}."
    names = joined([with_axes(entry, d.data.n_axes) for entry in _largest_first(d, parts)])
    text = f"The model lacks {names}: {before:.3g} {unit} RMS of error become {after:.3g}"
    is_rest = "" if d.verdict == "explained" else f"; more is missing, and {_followed(d)}"
    return f"{text}{is_rest}; {_sureness(alternatives, _doubtful(d))}."


def next_sentence(d: Diagnosis, alternatives: list[list[str]], parts: list[Contribution]) -> str:
    """The next step: what goes where, what to measure, which sensor to check."""
    steps = [f"check {_sensor(entry)}" for entry in d.fit.effects if entry.term.candidate.sensor]
    places: dict[str, list[str]] = {}
    for entry in _largest_first(d, parts):
        if not entry.term.candidate.sensor:
            places.setdefault(entry.term.candidate.hardware, []).append(plain(entry.name))
    into = [f"{joined(places[place])} into the {place}" for place in ("network", "compensator") if place in places]
    if alternatives:
        steps.append(f"measure what {_PLAN} writes before you trust the name {plain(alternatives[0][0])}")
    if into:
        how = (
            "gravcomp loop does it"
            if d.data.robot is not None and not d.data.is_predicted
            else "model.toml has the values"
        )
        steps.append(f"put {joined(into)} ({how})")
    if "none" in places:
        verb = "have" if len(places["none"]) > 1 else "has"
        steps.append(f"mend {joined(places['none'])} at the machine, which {verb} no place in the hardware")
    if d.verdict in ("partly_explained", "unexplained"):
        steps.append(_search_for(d))
    if not steps:
        blind = "log the approach velocity, without which no friction shows"
        steps.append("keep the model" if d.data.has_velocity else blind)
    return f"Next: {'; '.join(steps)}."


def _largest_first(d: Diagnosis, parts: list[Contribution]) -> list[Entry]:
    size = {own.name: own.whole for own in parts if own.kind == "effect"}
    return sorted(d.fit.effects, key=lambda entry: -size[entry.name])


def with_axes(entry: Entry, n_axes: int) -> str:
    """An effect and its axes, where it does not act on all of them."""
    axes = _axes(entry)
    is_on_all = not axes or len(axes) == n_axes
    return plain(entry.name) if is_on_all else f"{plain(entry.name)} on {_listed(axes)}"


def _axes(entry: Entry) -> list[int]:
    """From 1, of the parameters that belong to one."""
    return sorted({name.axis + 1 for name in entry.parameters if getattr(name, "axis", None) is not None})


def _listed(axes: list[int]) -> str:
    return f"{'axis' if len(axes) == 1 else 'axes'} {joined([str(axis) for axis in axes])}"


def plain(name: str) -> str:
    return name.replace("_", " ")


def joined(parts: list[str]) -> str:
    """a, b and c."""
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"


def _unnamed(d: Diagnosis) -> list[dict]:
    return [item for item in d.drivers if item["of"] == ""]


def _followed(d: Diagnosis) -> str:
    """What the unnamed part follows, the strongest first."""
    if any("two-valued" in note for note in d.notes):
        return "what is left is two-valued, as friction of an unknown direction"
    own = _unnamed(d)[:2]
    if not own:
        return "it follows no variable that was measured"
    return "it follows " + joined([f"{item['variable']} on axis {item['axis']}" for item in own])


def _search_for(d: Diagnosis) -> str:
    if any("two-valued" in note for note in d.notes):
        return "log the approach velocity"
    own = _unnamed(d)
    if own:
        return f"look at axis {own[0]['axis']} for what depends on {own[0]['variable']} and is on no list"
    return "measure more variables, or the same poses again, to see what the rest follows"


def _doubtful(d: Diagnosis) -> list[str]:
    """Effects by axis of which every parameter may be zero: what the log does not tell from nothing."""
    out = []
    for entry in d.fit.effects:
        by_axis: dict[int | None, list[bool]] = {}
        for name, (low, high) in entry.intervals.items():
            by_axis.setdefault(getattr(name, "axis", None), []).append(low <= 0.0 <= high)
        axes = sorted(axis + 1 for axis, own in by_axis.items() if axis is not None and all(own))
        if by_axis and all(map(all, by_axis.values())):
            out.append(plain(entry.name))
        elif axes:
            out.append(f"{plain(entry.name)} on {_listed(axes)}")
    return out


def _sureness(alternatives: list[list[str]], doubtful: list[str]) -> str:
    if not alternatives and not doubtful:
        return "any other name is at least 90 times less likely"
    sets = [f"{plain(names[0])} from {joined([plain(name) for name in names[1:]])}" for names in alternatives]
    words = [f"this log cannot tell {joined(sets)}"] if sets else []
    words += [f"of {joined(doubtful)} the interval reaches zero"] if doubtful else []
    return f"not sure: {', and '.join(words)}"


def _sensor(entry: Entry) -> str:
    axes = _axes(entry)
    return entry.term.candidate.sensor + (f" of {_listed(axes)}" if axes else "")
