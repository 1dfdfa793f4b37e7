"""Plant a fault at every output port of every entity, one at a time, and name the claim or the test that sees it."""

import json
import sys
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp_lab.mutation.ports import Found, Port, markdown, output_ports, try_port


def add_arguments(parser):
    parser.add_argument("--root", type=Path, default=Path(), help="folder that holds rtl/ and tb/")
    parser.add_argument("--entity", action="append", default=[], help="try only this one; may be given several times")
    parser.add_argument("--jobs", type=int, default=2, help="ports at a time (default 2)")
    parser.add_argument("--out", type=Path, default=Path("build/ports"), help="folder of the outcomes, a file each")
    parser.add_argument("--docs", type=Path, help="folder for ports.md, which is written from all outcomes")


def run(arguments):
    root = arguments.root.resolve()
    every = output_ports(root / "rtl")
    chosen = [port for port in every if not arguments.entity or port.entity in arguments.entity]

    def keep(port: Port) -> None:
        write_atomically(_file(arguments.out, port), json.dumps(asdict(try_port(port, root))))

    with ThreadPoolExecutor(arguments.jobs) as pool:
        list(tqdm(pool.map(keep, chosen), total=len(chosen), desc="ports"))
    found = [Found(**json.loads(path.read_text())) for port in every if (path := _file(arguments.out, port)).exists()]
    table = markdown(found, len(every))
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "ports.md", table)
    if any(not outcome.tool for outcome in found):
        sys.exit(1)


def _file(out: Path, port: Port) -> Path:
    return out / f"{port.entity}.{port.name}.json"
