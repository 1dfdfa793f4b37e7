"""Plant small faults in the VHDL, one at a time, and see that the tests catch them."""

import json
from dataclasses import asdict
from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp_lab.mutation import campaign
from gravcomp_lab.mutation.mutants import Mutant
from gravcomp_lab.mutation.trial import SURVIVED, Outcome


def add_arguments(parser):
    parser.add_argument("--root", type=Path, default=Path(), help="folder that holds rtl/ and tb/")
    parser.add_argument("--mutants", type=int, default=260, help="about how many over all entities (default 260)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    parser.add_argument("--entity", action="append", default=[], help="try only this one; may be given several times")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time (default 2)")
    parser.add_argument("--out", type=Path, default=Path("build/mutation"), help="folder of the outcomes, a file each")
    parser.add_argument("--survivors", action="store_true", help="try again those that survived the last time")
    parser.add_argument("--no-baseline", action="store_true", help="take it that the tests pass without a fault")
    parser.add_argument("--docs", type=Path, help="folder for mutation.md")


def run(arguments):
    root = arguments.root.resolve()
    planned = campaign.plan(root, arguments.mutants, arguments.seed, arguments.entity)
    if arguments.survivors:
        again = {o.mutant for o in _last(arguments.out) if o.result == SURVIVED}
        planned = {entity: (len(order), order) for entity, (_, all_of_it) in planned.items()
                   if (order := [m for m in all_of_it if m in again])}  # fmt: skip
    total = sum(min(share, len(order)) for share, order in planned.values())
    print(f"seed {arguments.seed}: {total} faults in {len(planned)} entities", flush=True)
    if planned and not arguments.no_baseline:
        campaign.check_baseline(root, planned, arguments.out / "baseline")
    with tqdm(total=total, desc="mutants") as bar:

        def keep(outcome: Outcome) -> None:
            write_atomically(arguments.out / f"{outcome.mutant.name}.json", json.dumps(asdict(outcome)))
            bar.update()

        campaign.run(root, planned, arguments.jobs, keep)
    equivalent = campaign.reasons(root / "tb" / "equivalent_mutants.toml")
    table = campaign.markdown(_last(arguments.out), equivalent, arguments.seed)
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "mutation.md", table)


def _last(out: Path) -> list[Outcome]:
    """Outcomes in the folder, of this run and of earlier ones."""
    records = [json.loads(path.read_text()) for path in sorted(out.glob("gc_*.json"))]
    return [Outcome(Mutant(**record["mutant"]), record["result"], record["test"]) for record in records]
