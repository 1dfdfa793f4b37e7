"""Prove the claims of tb/formal about the hardware: for every input, every run, without a bound."""

import os
import sys
from pathlib import Path

from tqdm import tqdm

from gravcomp.files import write_atomically
from gravcomp_lab.formal.claims import CLAIMS, verify

INTRODUCTION = """\
# What is proven about the hardware

Written by `make formal`. Each checker of `tb/formal` holds an entity, as GHDL writes it in Verilog, and asserts
something about it. Yosys makes an and-inverter graph of both; ABC's property-directed reachability finds an inductive
invariant for every assertion and verifies it: power-up fulfils it, each clock keeps it, it implies the assertion. So
the claims hold for every input in every clock, for ever, not for samples and not to a depth. Products are cut: any
value may stand for one, which can only make a claim harder to prove. Inputs that a checker leaves open are free too.
`tb/test_rtl_formal*.py` plant faults in the VHDL and see the assertions break.

`valid_pipeline` takes the latency of the core from the shortest run to a result, and then proves that every accepted
input has its result after exactly as many clocks, that there are no other results, and that `in_ready` rises in time.

`hidden_sums` and `output_sums` are written from the weights in the ROMs: an interval for every register from the weight
to the sum, each of which follows from those before it, and no adder that leaves its width, for any input. Of a product
they use only that it lies between the weight times the ends of an 18-bit operand. One proof per output; the hidden sums
of one lane are those of all.

`input_clamp`, `hidden_saturation`, `output_saturation` and `force_saturation` compare with the clipped value itself, at
the widths of the network that is shipped, for every value before the clip. `input_clamp` shows that a count within the
trained range reaches the multiplier whole, and that x is the truncated product there and that of the limit beyond.
`serial_core` is about gc_core_serial with the same network in the serial form: each accepted input is answered after
exactly its latency, and each output is its sum, clipped and flagged if so, and holds.

`axi` leaves the master free, and the core behind the registers too. From the first reset on: a response only to
a request that was taken, of its kind, held unchanged until the master takes it; at most three requests of a kind under
way; and each request answered within three clocks in which the master takes responses of either kind, which is liveness
as a bound. Nothing of gc_bus_side is abstracted. `interrupts` cuts what is loaded, so that any may be, at any time.

`crossing_pulse`, `crossing_bus` and `clock_monitor` leave both clocks free: each is an input, whose edges fall in any
order, together or never, as often as they like. A synchroniser that samples a level while it changes takes the old or
the new one; so it does here, by the order of the edges.

`brakes` holds gc_brakes with all that watches brakes: a brake is open in RUN, or alone in its test in HOLDING; all open
only after each was let go and held by either path alone. Codes of states and bits of causes come from the twin, which
is compared with gc_safety_pkg.

`biss` and `adc_spi` leave the level of the line free in every clock, at the shortest periods and frames; `biss` divides
the bits that it read by the polynomial anew. `uart_received` has the port's own sender on the line.

`speed_meter` runs with a time-out of five clocks, so that its clock has few values; only widths of counters depend on
it. `friction` cuts both tables, so that any value may come out of them, and its product, which lies between its bounds.
PDR was given up for `loader` (an image has some 6000 words) and `friction` after 30 s, for `bank_switch` (615 bits of
constants) after almost five minutes, and never tried for long on `drive` (32-bit sums). Their assertions say what each
register holds, too, and are inductive together,
one clock from the one before; those of `friction` over the length of its pipeline. `drive` is proven axis by axis: all
three at once took the solver more than three minutes. That the CRC of `loader` is that of zlib is left to simulation.

`tb/test_rtl_formal_equivalence.py` proves the netlist equal to the RTL, by Yosys' `equiv_induct`, for the entities
that it names: that of Yosys' gates and that of ECP5's LUT4, CCU2C, PFUMX, L6MUX21 and TRELLIS_FF, with Yosys' models of
them. It pairs signals by name, each pair equal as long as all pairs were; values at power-up are not compared. Left
out are larger entities, for which the induction takes minutes (`gc_safety`) or does not close, and those with
multipliers: the netlist of the whole core is [simulated](netlist.md).

"""
HEAD = "| checker | entity | generics | assertions | verdict | processor s |\n|---|---|---|---|---|---|"


def add_arguments(parser):
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of the VHDL and its sources.f")
    parser.add_argument("--checkers", type=Path, default=Path("tb/formal"), help="folder of the checkers")
    parser.add_argument("--out", type=Path, default=Path("build/formal"), help="folder of intermediate files")
    parser.add_argument("--docs", type=Path, help="folder for formal.md")


def run(arguments):
    rows, all_hold, total_s = [], True, 0.0
    for claim in tqdm(CLAIMS, desc="formal", delay=2):
        began = _processor_s()
        verdict = verify(claim, arguments.rtl, arguments.checkers, arguments.out)
        seconds = _processor_s() - began
        all_hold, total_s = all_hold and verdict.holds, total_s + seconds
        settings = {**claim.generics, **({} if claim.axis is None else {"axis": claim.axis + 1})}
        generics = ", ".join(f"{name} = {value}" for name, value in settings.items())
        names = ", ".join(sorted({*verdict.proven, *verdict.broken, *verdict.open}))
        faults = [f"{name} broken after {clocks} clocks" for name, clocks in verdict.broken.items()]
        faults += [f"{name} open" for name in verdict.open]
        told = "; ".join(faults) or "proven"
        rows.append(f"| {claim.checker} | {claim.entity} | {generics} | {names} | {told} | {seconds:.0f} |")
    table = "\n".join([HEAD, *rows, f"| all | | | | | {total_s:.0f} |"])
    print(table)
    if arguments.docs:
        write_atomically(arguments.docs / "formal.md", INTRODUCTION + table + "\n")
    if not all_hold:
        sys.exit(1)


def _processor_s() -> float:
    """Processor time of this process and of those that it waited for: no other load changes it much."""
    return sum(os.times()[:4])
