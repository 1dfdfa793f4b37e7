"""The IP-XACT component of an entity with an AXI4-Lite slave, for block designs.

IEEE 1685-2009 with the names of Vivado's buses, views and extensions: that is what Vivado's block designs read. Ports
are grouped by their names: s_axi_* is the slave, *clk a clock, *aresetn its reset, irq the interrupt.
"""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

from gravcomp.driver.registers import SPIRIT
from gravcomp.errors import InputError
from gravcomp_lab.ipxact.entity import Entity, Generic, Port

XILINX = "http://www.xilinx.com"
SCRIPT = "component.tcl"  # beside the component: how Vivado hands the user's parameters to the generics
_HEADER = "<?xml version='1.0' encoding='UTF-8'?>\n<!-- Written by `make regs`. -->\n"
_BUS = "s_axi"
_VIEWS = {"synthesis": "xilinx_vhdlsynthesis", "simulation": "xilinx_vhdlbehavioralsimulation"}
_SCRIPT_VIEW = "xilinx_xpgui"
_FORMATS = {  # VHDL type: IP-XACT data type, format, smallest value
    "positive": ("integer", "long", "1"),
    "natural": ("integer", "long", "0"),
    "boolean": ("boolean", "bool", None),
}
_FAMILIES = """artix7 kintex7 spartan7 virtex7 zynq kintexu virtexu artixuplus kintexuplus virtexuplus zynquplus
versal"""
ElementTree.register_namespace("spirit", SPIRIT)
ElementTree.register_namespace("xilinx", XILINX)


def component(entity: Entity, sources: Sequence[str], register_map: Path) -> str:
    """The XML. sources: in compile order, relative to the component. register_map: PeakRDL's IP-XACT, 1685-2009.

    Vendor, library and version are those of the register map; Vivado's versions have two numbers, the third is its
    revision. Raises InputError when the map cannot be read, or a generic has a type that has no counterpart here.
    """
    try:
        root = ElementTree.parse(register_map).getroot()
    except (OSError, ElementTree.ParseError) as error:
        raise InputError(f"{register_map}: no register map ({error}); write it with `make regs`") from error
    root.find(f"{{{SPIRIT}}}name").text = entity.name
    version = root.find(f"{{{SPIRIT}}}version")
    version.text, revision = version.text.rsplit(".", 1)
    maps = root.find(f"{{{SPIRIT}}}memoryMaps")
    _complete(maps, entity)
    root.remove(maps)
    _add_interfaces(root, entity)
    root.append(maps)
    _add_model(root, entity)
    _add_files(root, sources)
    _add(root, "description", entity.description)
    _add_parameters(root, entity)
    _add_extensions(root, revision)
    ElementTree.indent(root)
    return _HEADER + ElementTree.tostring(root, "unicode") + "\n"


def dialogue(entity: Entity) -> str:
    """The Tcl procedures that Vivado calls to show the parameters and to hand them to the generics."""
    names = [generic.name for generic in entity.generics]
    shown = "".join(f"    ipgui::add_param $IPINST -name {name}\n" for name in ("Component_Name", *names))
    return f"# Written by `make regs`.\n\nproc init_gui {{IPINST}} {{\n{shown}}}\n" + "".join(
        f"""
proc update_PARAM_VALUE.{name} {{PARAM_VALUE.{name}}} {{}}

proc validate_PARAM_VALUE.{name} {{PARAM_VALUE.{name}}} {{
    return true
}}

proc update_MODELPARAM_VALUE.{name} {{MODELPARAM_VALUE.{name} PARAM_VALUE.{name}}} {{
    set_property value [get_property value ${{PARAM_VALUE.{name}}}] ${{MODELPARAM_VALUE.{name}}}
}}
"""
        for name in names
    )


def _add(parent: ElementTree.Element, name: str, text: str | None = None, /, space: str = SPIRIT, **attributes: str):
    """A new child element, its attributes in the namespace of IP-XACT."""
    child = ElementTree.SubElement(parent, f"{{{space}}}{name}", {f"{{{space}}}{k}": v for k, v in attributes.items()})
    child.text = text
    return child


def _complete(maps: ElementTree.Element, entity: Entity) -> None:
    """Name the map as the bus, and give its block all addresses that the bus decodes."""
    (address_bits,) = (port.bits for port in entity.ports if port.name == f"{_BUS}_awaddr")
    maps.find(f".//{{{SPIRIT}}}name").text = _BUS
    block = maps.find(f".//{{{SPIRIT}}}addressBlock")
    block.find(f"{{{SPIRIT}}}range").text = str(2**address_bits)
    usage = ElementTree.Element(f"{{{SPIRIT}}}usage")
    usage.text = "register"
    block.insert(list(block).index(block.find(f"{{{SPIRIT}}}width")) + 1, usage)


def _add_interfaces(root: ElementTree.Element, entity: Entity) -> None:
    names = [port.name for port in entity.ports]
    clocks = [name for name in names if name.endswith("clk")]
    resets = [name for name in names if name.endswith("aresetn")]
    signals = [name for name in names if name.startswith(f"{_BUS}_") and name not in (*clocks, *resets)]
    interfaces = _add(root, "busInterfaces")
    logical = {name.removeprefix(f"{_BUS}_").upper(): name for name in signals}
    _add_interface(interfaces, _BUS, "interface:aximm", logical, {"PROTOCOL": "AXI4LITE"}, memory_map=_BUS)
    for name in clocks:
        reset = f"{_BUS}_aresetn" if name == f"{_BUS}_aclk" else None
        associated = {"ASSOCIATED_BUSIF": _BUS, "ASSOCIATED_RESET": reset} if reset else {}
        _add_interface(interfaces, name, "signal:clock", {"CLK": name}, associated)
    for name in resets:
        _add_interface(interfaces, name, "signal:reset", {"RST": name}, {"POLARITY": "ACTIVE_LOW"})
    _add_interface(interfaces, "irq", "signal:interrupt", {"INTERRUPT": "irq"}, {"SENSITIVITY": "LEVEL_HIGH"}, "master")


def _add_interface(
    interfaces: ElementTree.Element,
    name: str,
    kind: str,
    ports: dict[str, str],
    parameters: dict[str, str],
    mode: str = "slave",
    memory_map: str | None = None,
) -> None:
    """One of Xilinx's buses: kind is its library and name, ports its logical and our physical names."""
    library, bus = kind.split(":")
    interface = _add(interfaces, "busInterface")
    _add(interface, "name", name)
    for element, suffix in (("busType", ""), ("abstractionType", "_rtl")):
        _add(interface, element, vendor="xilinx.com", library=library, name=bus + suffix, version="1.0")
    side = _add(interface, mode)
    if memory_map:
        _add(side, "memoryMapRef", memoryMapRef=memory_map)
    maps = _add(interface, "portMaps")
    for logical, physical in ports.items():
        port_map = _add(maps, "portMap")
        _add(_add(port_map, "logicalPort"), "name", logical)
        _add(_add(port_map, "physicalPort"), "name", physical)
    if parameters:
        listed = _add(interface, "parameters")
        for key, value in parameters.items():
            parameter = _add(listed, "parameter")
            _add(parameter, "name", key)
            _add(parameter, "value", value, id=f"BUSIFPARAM_VALUE.{name.upper()}.{key}")


def _add_model(root: ElementTree.Element, entity: Entity) -> None:
    model = _add(root, "model")
    views = _add(model, "views")
    for use, name in _VIEWS.items():
        view = _add(views, "view")
        _add(view, "name", name)
        _add(view, "envIdentifier", f"vhdlSource:vivado.xilinx.com:{use}")
        _add(view, "language", "vhdl")
        _add(view, "modelName", entity.name)
        _add(_add(view, "fileSetRef"), "localName", f"{name}_view_fileset")
    view = _add(views, "view")
    _add(view, "name", _SCRIPT_VIEW)
    _add(view, "envIdentifier", ":vivado.xilinx.com:xgui.ui")
    _add(_add(view, "fileSetRef"), "localName", f"{_SCRIPT_VIEW}_view_fileset")
    ports = _add(model, "ports")
    for port in entity.ports:
        _add_port(ports, port)
    parameters = _add(model, "modelParameters")
    for generic in entity.generics:
        parameter = _add(parameters, "modelParameter", dataType=_format(generic)[0])
        _add_value(parameter, generic, "generated", "MODELPARAM_VALUE")


def _add_port(ports: ElementTree.Element, port: Port) -> None:
    element = _add(ports, "port")
    _add(element, "name", port.name)
    if port.description:
        _add(element, "description", port.description)
    wire = _add(element, "wire")
    _add(wire, "direction", port.direction)
    if port.bits is not None:
        vector = _add(wire, "vector")
        _add(vector, "left", str(port.bits - 1), format="long")
        _add(vector, "right", "0", format="long")
    definition = _add(_add(wire, "wireTypeDefs"), "wireTypeDef")
    _add(definition, "typeName", port.kind)
    for view in _VIEWS.values():
        _add(definition, "viewNameRef", view)


def _add_files(root: ElementTree.Element, sources: Sequence[str]) -> None:
    sets = _add(root, "fileSets")
    for view in _VIEWS.values():
        files = _add(sets, "fileSet")
        _add(files, "name", f"{view}_view_fileset")
        for source in sources:
            file = _add(files, "file")
            _add(file, "name", source)
            # 1685-2009 knows no VHDL-2008; this is how Vivado writes it.
            _add(file, "userFileType", "vhdlSource-2008")
            _add(file, "logicalName", "gravcomp")
    files = _add(sets, "fileSet")
    _add(files, "name", f"{_SCRIPT_VIEW}_view_fileset")
    file = _add(files, "file")
    _add(file, "name", SCRIPT)
    _add(file, "fileType", "tclSource")
    _add(file, "userFileType", "XGUI_VERSION_2")


def _add_parameters(root: ElementTree.Element, entity: Entity) -> None:
    parameters = _add(root, "parameters")
    for generic in entity.generics:
        _add_value(_add(parameters, "parameter"), generic, "user", "PARAM_VALUE")
    parameter = _add(parameters, "parameter")
    _add(parameter, "name", "Component_Name")
    _add(parameter, "value", entity.name, resolve="user", id="PARAM_VALUE.Component_Name")


def _add_value(parameter: ElementTree.Element, generic: Generic, resolve: str, prefix: str) -> None:
    _, form, least = _format(generic)
    _add(parameter, "name", generic.name)
    if generic.description:
        _add(parameter, "description", generic.description)
    limits = {"minimum": least, "rangeType": "long"} if least and resolve == "user" else {}
    _add(parameter, "value", generic.default, format=form, resolve=resolve, id=f"{prefix}.{generic.name}", **limits)


def _format(generic: Generic) -> tuple[str, str, str | None]:
    try:
        return _FORMATS[generic.kind]
    except KeyError:
        raise InputError(f"{generic.name}: no IP-XACT format for {generic.kind}; use {', '.join(_FORMATS)}") from None


def _add_extensions(root: ElementTree.Element, revision: str) -> None:
    extensions = _add(_add(root, "vendorExtensions"), "coreExtensions", space=XILINX)
    families = _add(extensions, "supportedFamilies", space=XILINX)
    for family in _FAMILIES.split():
        _add(families, "family", family, space=XILINX, lifeCycle="Production")
    _add(_add(extensions, "taxonomies", space=XILINX), "taxonomy", "/UserIP", space=XILINX)
    _add(extensions, "coreRevision", revision, space=XILINX)
