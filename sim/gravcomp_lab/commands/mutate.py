"""Plant small faults in the VHDL, one at a time, and see that the tests catch them.

Faults whose verdict still holds are not tried again.
"""

from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp.parallel import WHERE
from gravcomp_lab.mutation import campaign
from gravcomp_lab.mutation.trial import Outcome
from gravcomp_lab.mutation.verdicts import Verdicts


def add_arguments(parser):
    parser.add_argument("--root", type=Path, default=Path(), help="folder that holds rtl/ and tb/")
    parser.add_argument("--mutants", type=int, default=440, help="about how many over all entities (default 440)")
    parser.add_argument("--seed", type=int, default=1, help="of the draw (default 1)")
    parser.add_argument("--entity", action="append", default=[], help="try only this one; may be given several times")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time (default 2)")
    parser.add_argument("--backend", choices=WHERE, default=WHERE[0], help="where they are tried (default %(default)s)")
    parser.add_argument("--out", type=Path, default=Path("build/mutation"), help="folder of the baseline's simulations")
    parser.add_argument(
        "--verdicts", type=Path, default=Path("docs/measured/mutation.csv"), help="table of what became of each fault"
    )
    parser.add_argument("--no-baseline", action="store_true", help="take it that the tests pass without a fault")
    parser.add_argument("--known", action="store_true", help="try none: tell what the verdicts that hold say")
    parser.add_argument("--docs", type=Path, help="folder for mutation.md; needs a run over all entities")


def run(arguments):
    root = arguments.root.resolve()
    planned = campaign.plan(root, arguments.mutants, arguments.seed, arguments.entity)
    verdicts = Verdicts(arguments.verdicts, root)
    total = sum(min(share, len(order)) for share, order in planned.values())
    print(f"seed {arguments.seed}: {total} faults in {len(planned)} entities", flush=True)
    equivalent = campaign.reasons(root / "tb" / "equivalent_mutants.toml")
    if arguments.known:
        outcomes = campaign.known(planned, verdicts)
    else:
        outcomes = _tried(planned, verdicts, total, equivalent, arguments)
    table = campaign.markdown(outcomes, equivalent, arguments.seed, total)
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "mutation.md", table)


def _tried(planned, verdicts: Verdicts, total: int, equivalent, arguments) -> list[Outcome]:
    """The outcomes of all total faults, of which those without a verdict are tried."""
    root, entities = arguments.root.resolve(), campaign.to_try(planned, verdicts)
    print(f"to be tried: {', '.join(entities) or 'none, every verdict still holds'}", flush=True)
    if entities and not arguments.no_baseline:
        campaign.check_baseline(root, entities, arguments.out / "baseline")
    with tqdm(total=total, desc="mutants") as bar:

        def tell(outcome: Outcome) -> None:
            bar.update()

        return campaign.run(root, planned, arguments.jobs, verdicts, tell, equivalent, arguments.backend)
