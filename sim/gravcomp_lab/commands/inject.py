"""Flip single bits in every register and memory of gc_system while it holds a pose; docs/measured/injection.md."""

from argparse import Namespace
from collections.abc import Mapping
from pathlib import Path

from tqdm import tqdm

from gravcomp.errors import InputError
from gravcomp_lab.inject import campaign, report, specimen
from gravcomp_lab.pages import read, renew
from gravcomp_lab.simulated.pictures import save_figure


def add_arguments(parser):
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f")
    parser.add_argument("--bench", type=Path, default=Path("tb/inject/bench.cpp"), help="the bench in C++")
    parser.add_argument("--weights", type=Path, default=Path("weights/spheiro"), help="folder of the network")
    parser.add_argument("--variant", nargs="+", default=list(campaign.VARIANTS), choices=list(campaign.VARIANTS))
    parser.add_argument(
        "--entity", action="append", default=[], help="flip bits of this one alone; may be given several times"
    )
    parser.add_argument("--flips", type=int, default=300, help="of live state, per entity (default 300)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    parser.add_argument("--jobs", type=int, default=2, help="benches at a time (default 2)")
    parser.add_argument("--out", type=Path, default=Path("build/inject"), help="folder of the outcomes; a run goes on")
    parser.add_argument("--docs", type=Path, help="folder whose injection.md and picture are to be renewed")


def run(arguments):
    if arguments.flips < 1 or arguments.jobs < 1:
        raise InputError(f"--flips {arguments.flips} --jobs {arguments.jobs}: need one or more of each")
    tables = {}
    for variant in arguments.variant:
        parts = _inject(variant, arguments)
        if arguments.docs:
            page = arguments.docs / "injection.md"
            for part in parts:
                if arguments.entity and part != "braked":
                    parts[part] = report.merged(read(page, f"{variant} {part}"), parts[part], arguments.entity)
                if not arguments.entity or part != "braked":
                    renew(page, f"{variant} {part}", parts[part])
        print("\n\n".join([f"# {variant}", *parts.values()]), flush=True)
        tables[variant] = parts["exhaustive"], parts["sampled"]
    save_figure(_picture(tables), arguments.out / "injection.png")
    if arguments.docs:
        page = arguments.docs / "injection.md"
        tables = {name: (read(page, f"{name} exhaustive"), read(page, f"{name} sampled")) for name in campaign.VARIANTS}
        save_figure(_picture(tables), arguments.docs / "figures" / "injection.png")


def _picture(tables: Mapping[str, tuple[str, str]]):
    """Of the tables of each variant: every bit, and drawn ones."""
    titles = ("every bit", "live state, drawn")
    panels = [
        (f"{name}: {title}", table) for name, of in tables.items() for title, table in zip(titles, of, strict=True)
    ]
    return report.picture({title: report.shares(table) for title, table in panels})


def _inject(variant: str, arguments: Namespace) -> dict[str, str]:
    """The parts of the page about a variant; with --entity their rows are those of these entities."""
    made = campaign.prepare(
        arguments.rtl, arguments.weights, arguments.bench, variant, arguments.out / variant, arguments.seed
    )
    live = {name: made.live(name, arguments.entity) for name in campaign.SAMPLED_SCENES}
    exhaustive, sample = (
        [flip for flip in flips if not arguments.entity or made.design.stores[flip.store].entity in arguments.entity]
        for flips in (made.exhaustive(campaign.EXHAUSTIVE_SCENES, live["rom"]), made.sample(live, arguments.flips))
    )
    print(
        f"{variant}, seed {arguments.seed}: {len(exhaustive)} flips of every bit, {len(sample)} of live state",
        flush=True,
    )
    with tqdm(total=len(exhaustive) + len(sample), desc=variant) as bar:
        outcomes = made.run([*exhaustive, *sample], arguments.jobs, bar.update)
    ua_per_mn, stores = specimen.ua_per_mn(arguments.weights), made.design.stores
    every_bit = report.judge(stores, exhaustive, outcomes[: len(exhaustive)], ua_per_mn)
    drawn = report.judge(stores, sample, outcomes[len(exhaustive) :], ua_per_mn)
    both = [*every_bit, *drawn]
    return {
        "exhaustive": report.table(every_bit, stores),
        "sampled": report.table(drawn, stores, campaign.live_bits(live)),
        "silent": report.silent_table(both, ua_per_mn),
        "braked": f"Lanes: {campaign.LANES}. Seed {arguments.seed}. "
        "Longest time with a wrong command before the brakes engaged: "
        f"{report.worst_before_brakes_us(both):.1f} us.",
    }
