"""Prove the claims of tb/formal about the hardware: for every input, every run, without a bound."""

import sys
import time
from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp.formal.claims import CLAIMS, verify

INTRODUCTION = """\
# What is proven about the hardware

Written by `make formal`. Each checker of `tb/formal` holds an entity, as GHDL writes it in Verilog, and asserts
something about it. Yosys makes an and-inverter graph of both; ABC's property-directed reachability finds an inductive
invariant for every assertion and verifies it: power-up fulfils it, each clock keeps it, it implies the assertion. So
the claims hold for every input in every clock, for ever, not for samples and not to a depth. Products are cut: any
value may stand for one, which can only make a claim harder to prove. `tb/test_rtl_formal*.py` plant faults in the VHDL
and see the assertions break.

`valid_pipeline` takes the latency of the core from the shortest run to a result, and then proves that every accepted
input has its result after exactly as many clocks, that there are no other results, and that `in_ready` rises in time.

`hidden_sums` and `output_sums` are written from the weights in the ROMs: an interval for every register from the weight
to the sum, each of which follows from those before it, and no adder that leaves its width, for any input. Of a product
they use only that it lies between the weight times the ends of an 18-bit operand. With 20 lanes the graph of
`output_sums` is too large to be proven in a reasonable time; its terms and its width are the same.

`tb/test_rtl_formal_equivalence.py` proves the gate netlist equal to the RTL, by Yosys' `equiv_induct`, for the entities
that it names.

"""
HEAD = "| checker | entity | generics | assertions | verdict | s |\n|---|---|---|---|---|---|"


def add_arguments(parser):
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of the VHDL and its sources.f")
    parser.add_argument("--checkers", type=Path, default=Path("tb/formal"), help="folder of the checkers")
    parser.add_argument("--out", type=Path, default=Path("build/formal"), help="folder of intermediate files")
    parser.add_argument("--docs", type=Path, help="folder for formal.md")


def run(arguments):
    rows, all_hold = [], True
    for claim in tqdm(CLAIMS, desc="formal", delay=2):
        began = time.perf_counter()
        verdict = verify(claim, arguments.rtl, arguments.checkers, arguments.out)
        seconds = time.perf_counter() - began
        all_hold = all_hold and verdict.holds
        generics = ", ".join(f"{name} = {value}" for name, value in claim.generics.items())
        names = ", ".join(sorted({*verdict.proven, *verdict.broken, *verdict.open}))
        faults = [f"{name} broken after {clocks} clocks" for name, clocks in verdict.broken.items()]
        faults += [f"{name} open" for name in verdict.open]
        told = "; ".join(faults) or "proven"
        rows.append(f"| {claim.checker} | {claim.entity} | {generics} | {names} | {told} | {seconds:.0f} |")
    table = "\n".join([HEAD, *rows])
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "formal.md", INTRODUCTION + table + "\n")
    if not all_hold:
        sys.exit(1)
