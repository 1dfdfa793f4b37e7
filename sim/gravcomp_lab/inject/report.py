"""The outcomes of a campaign as tables and as a picture."""

from collections.abc import Sequence
from dataclasses import dataclass

from gravcomp_lab.inject.campaign import Flip
from gravcomp_lab.inject.outcome import BRAKED, CLASSES, SILENT, Outcome, classify, counts, upper_bound
from gravcomp_lab.inject.state import Store

COLOURS = ("tab:green", "tab:blue", "tab:olive", "tab:red")
CLOCKS_PER_US = 40


@dataclass(frozen=True)
class Judged:
    """A flip, where it was, what it did and the class of that."""

    flip: Flip
    store: Store
    outcome: Outcome
    verdict: str


def judge(
    stores: Sequence[Store], flips: Sequence[Flip], outcomes: Sequence[Outcome], ua_per_mn: float
) -> list[Judged]:
    """Every flip with its class."""
    return [
        Judged(flip, stores[flip.store], outcome, classify(outcome, ua_per_mn))
        for flip, outcome in zip(flips, outcomes, strict=True)
    ]


def table(judged: Sequence[Judged], stores: Sequence[Store], live_bits: Sequence[int] | None = None) -> str:
    """A row per entity. live_bits, one number per store, adds the size of the population and the bounds of a sample."""
    header = ["entity", *(["state bits", "live"] if live_bits else ["bits"]), "flips", *CLASSES]
    header += ["silently wrong, 95 % bound"] if live_bits else []
    rows = [_row(entity, judged, stores, live_bits) for entity in sorted({j.store.entity for j in judged})]
    rows += [_row(None, judged, stores, live_bits)]
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (header, ["---"] * len(header), *rows))


def _row(
    entity: str | None, judged: Sequence[Judged], stores: Sequence[Store], live_bits: Sequence[int] | None
) -> list:
    here = [j for j in judged if entity in (None, j.store.entity)]
    touched = {j.store.entity for j in here}
    numbers = [k for k, s in enumerate(stores) if s.entity in touched]
    if not live_bits:
        numbers = sorted({j.flip.store for j in here})
    n, bits = counts([j.verdict for j in here]), sum(stores[k].bits * (stores[k].depth or 1) for k in numbers)
    row = [entity or "**all**", bits]
    row += [sum(live_bits[k] for k in numbers)] if live_bits else []
    row += [len(here), *n.values()]
    return row + ([f"{100 * upper_bound(n[SILENT], len(here)):.2f} %"] if live_bits else [])


def silent_table(judged: Sequence[Judged], ua_per_mn: float) -> str:
    """A row per register in which a flip was silently wrong: how many of how many, how wrong, for how long."""
    groups: dict[tuple[str, str], list[Judged]] = {}
    for j in judged:
        groups.setdefault((j.store.entity, j.store.name), []).append(j)
    header = ["entity", "register", "silently wrong", "of", "largest error, mN", "for good", "brakes or enable differ"]
    rows = []
    for (entity, name), group in sorted(groups.items()):
        silent = [j.outcome for j in group if j.verdict == SILENT]
        if silent:
            error_mn = max(max(o.largest_ua) for o in silent) / ua_per_mn
            for_good = sum(not o.converged for o in silent)
            pins = sum(o.brake_clocks > 0 for o in silent)
            rows.append([entity, f"`{name}`", len(silent), len(group), f"{error_mn:.0f}", for_good, pins])
    return "\n".join(f"| {' | '.join(map(str, row))} |" for row in (header, ["---"] * len(header), *rows))


def worst_before_brakes_us(judged: Sequence[Judged]) -> float:
    """Longest time with a command more than 1 % off before the brakes engaged, of the flips that ended braked."""
    return max((j.outcome.wrong_clocks for j in judged if j.verdict == BRAKED), default=0) / CLOCKS_PER_US


def picture(panels: dict[str, Sequence[Judged]]):
    """Per panel a bar per entity, of the shares of the classes. Returns a Matplotlib figure."""
    from matplotlib.figure import Figure

    entities = [sorted({j.store.entity for j in judged}, reverse=True) for judged in panels.values()]
    figure = Figure(figsize=(5.5 * len(panels), 1.5 + 0.24 * max(map(len, entities))), layout="constrained")
    for k, ((title, judged), names) in enumerate(zip(panels.items(), entities, strict=True)):
        axes, left = figure.add_subplot(1, len(panels), k + 1), [0.0] * len(names)
        shares = [counts([j.verdict for j in judged if j.store.entity == name]) for name in names]
        for verdict, colour in zip(CLASSES, COLOURS, strict=True):
            widths = [100 * share[verdict] / sum(share.values()) for share in shares]
            axes.barh(names, widths, left=left, color=colour, label=verdict)
            left = [a + b for a, b in zip(left, widths, strict=True)]
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("share of the flips, %")
        axes.set_xlim(0, 100)
        axes.tick_params(axis="y", labelsize=8)
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(CLASSES))
    return figure
