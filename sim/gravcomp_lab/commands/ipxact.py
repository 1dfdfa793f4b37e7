"""Write the IP-XACT component of gc_system beside the VHDL, for block designs; `make regs` calls this."""

from pathlib import Path

from gravcomp.files import write_all_atomically
from gravcomp_lab.ipxact.component import SCRIPT, component, dialogue
from gravcomp_lab.ipxact.entity import read_entity

ENTITY = "gc_system"


def add_arguments(parser):
    parser.add_argument("registers", type=Path, help="the register map, IP-XACT 1685-2009 as PeakRDL writes it")
    parser.add_argument("--rtl", type=Path, default=Path("rtl"), help="folder of sources.f (default: rtl)")
    parser.add_argument("--out", type=Path, help="folder of the component (default: that of sources.f)")


def run(arguments):
    out = arguments.out or arguments.rtl
    entity = read_entity(arguments.rtl, ENTITY)
    sources = (arguments.rtl / "sources.f").read_text().split()
    xml = component(entity, sources, arguments.registers)
    write_all_atomically({out / "component.xml": xml, out / SCRIPT: dialogue(entity)})
    print(f"{out / 'component.xml'}: {len(entity.ports)} ports, {len(entity.generics)} generics, {len(sources)} files")
