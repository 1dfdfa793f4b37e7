"""Plant a fault at every output port of every entity, one at a time, and name the claim or the test that sees it.

Ports whose verdict still holds are not tried again.
"""

import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp_lab.mutation.ports import PortVerdicts, markdown, output_ports, try_port


def add_arguments(parser):
    parser.add_argument("--root", type=Path, default=Path(), help="folder that holds rtl/ and tb/")
    parser.add_argument("--entity", action="append", default=[], help="try only this one; may be given several times")
    parser.add_argument("--jobs", type=int, default=2, help="ports at a time (default 2)")
    parser.add_argument(
        "--verdicts", type=Path, default=Path("docs/measured/ports.csv"), help="table of what found each fault"
    )
    parser.add_argument("--docs", type=Path, help="folder for ports.md, which is written from all verdicts that hold")


def run(arguments):
    root = arguments.root.resolve()
    every, verdicts = output_ports(root / "rtl"), PortVerdicts(arguments.verdicts, root)
    chosen = [port for port in every if not arguments.entity or port.entity in arguments.entity]
    to_try = [port for port in chosen if not verdicts.known(port)]
    print(f"{len(chosen)} ports, to be tried: {len(to_try)}", flush=True)
    with ThreadPoolExecutor(arguments.jobs) as pool:
        trials = [pool.submit(try_port, port, root) for port in to_try]
        for trial in tqdm(as_completed(trials), total=len(trials), desc="ports"):
            verdicts.keep(trial.result())
    found = [verdict for port in every if (verdict := verdicts.known(port))]
    table = markdown(found, len(every))
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "ports.md", table)
    if any(not verdict.tool for verdict in found):
        sys.exit(1)
