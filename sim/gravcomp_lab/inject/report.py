"""The outcomes of a campaign as tables and as a picture."""

from collections.abc import Sequence
from dataclasses import dataclass

from gravcomp_lab.inject.campaign import Flip
from gravcomp_lab.inject.outcome import BRAKED, CLASSES, SILENT, Outcome, classify, counts, upper_bound
from gravcomp_lab.inject.state import Store

COLOURS = ("tab:green", "tab:blue", "tab:olive", "tab:red")
CLOCKS_PER_US = 40
ALL = "**all**"


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
    row = [entity or ALL, bits]
    row += [sum(live_bits[k] for k in numbers)] if live_bits else []
    row += [len(here), *n.values()]
    return row + ([_percent(n[SILENT], len(here))] if live_bits else [])


def _percent(n_found: int, n: int) -> str:
    """The bound of a share."""
    return f"{100 * upper_bound(n_found, n):.2f} %"


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


def merged(old: str, new: str, entities: Sequence[str]) -> str:
    """A table in which the rows of some entities are those of another, with the sums of all of them."""
    head, rows = new.splitlines()[:2], [*_rows(old, entities, False), *_rows(new, entities, True)]
    rows.sort(key=lambda row: row[:2])
    if ALL in (_cells(line)[0] for line in new.splitlines()):
        n_counts = len(_cells(head[0])) - 1 - _bounded(head[0])
        sums = [sum(int(row[1 + k]) for row in rows) for k in range(n_counts)]
        bound = [_percent(sums[-1], sums[-1 - len(CLASSES)])] * _bounded(head[0])
        rows.append([ALL, *map(str, sums), *bound])
    return "\n".join([*head, *(f"| {' | '.join(row)} |" for row in rows)])


def _rows(table: str, entities: Sequence[str], chosen: bool) -> list[list[str]]:
    rows = [_cells(line) for line in table.splitlines()[2:]]
    return [row for row in rows if row[0] != ALL and (row[0] in entities) == chosen]


def _cells(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def _bounded(header: str) -> bool:
    return _cells(header)[-1].endswith("bound")


def shares(table: str) -> dict[str, dict[str, float]]:
    """Per entity of a table the shares of the classes, %."""
    header, rows = _cells(table.splitlines()[0]), [_cells(line) for line in table.splitlines()[2:]]
    numbers = {row[0]: {name: int(row[header.index(name)]) for name in CLASSES} for row in rows if row[0] != ALL}
    return {entity: {name: 100 * n / sum(of.values()) for name, n in of.items()} for entity, of in numbers.items()}


def picture(panels: dict[str, dict[str, dict[str, float]]]):
    """Per panel a bar per entity, of the shares of the classes, %. Returns a Matplotlib figure."""
    from matplotlib.figure import Figure

    entities = [sorted(shares, reverse=True) for shares in panels.values()]
    figure = Figure(figsize=(5.5 * len(panels), 1.5 + 0.24 * max(map(len, entities))), layout="constrained")
    for k, ((title, shares), names) in enumerate(zip(panels.items(), entities, strict=True)):
        axes, left = figure.add_subplot(1, len(panels), k + 1), [0.0] * len(names)
        for verdict, colour in zip(CLASSES, COLOURS, strict=True):
            widths = [shares[name][verdict] for name in names]
            axes.barh(names, widths, left=left, color=colour, label=verdict)
            left = [a + b for a, b in zip(left, widths, strict=True)]
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("share of the flips, %")
        axes.set_xlim(0, 100)
        axes.tick_params(axis="y", labelsize=8)
    figure.legend(*figure.axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=len(CLASSES))
    return figure
