"""The IP-XACT component of gc_system for other axes than the one that comes with gravcomp.

What there is per axis shows in what is shipped: of registers and fields, where the map of the most axes differs; of
ports, in the VHDL, whose ranges name axes_c.
"""

import re
from xml.etree import ElementTree

from gravcomp.driver.registers import SPIRIT
from gravcomp.shipped import shipped

COMPONENT_XML = "rtl/component.xml"
_MOST_AXES_XML, _ENTITY = "rtl/registers/gc_registers.xml", "rtl/system/gc_system.vhd"
_NAMESPACES = {
    "spirit": SPIRIT,
    "xilinx": "http://www.xilinx.com",
    "xsi": "http://www.w3.org/2001/XMLSchema-instance",
}
_XML = {"x": SPIRIT}
_HEADER = "<?xml version='1.0' encoding='UTF-8'?>\n<!-- Written by `gravcomp new`. -->\n"


def component_text(n_axes: int) -> str:
    """The XML of the component that is shipped, with registers, fields and ports of so many axes."""
    for prefix, uri in _NAMESPACES.items():
        ElementTree.register_namespace(prefix, uri)
    root = ElementTree.parse(shipped(COMPONENT_XML)).getroot()
    numbers, most = _numbers(root), _numbers(ElementTree.parse(shipped(_MOST_AXES_XML)).getroot())
    shipped_axes = int(numbers["position"].text)
    for place, number in numbers.items():
        if number.text != most[place].text:
            number.text = str(n_axes)
    for name in re.findall(r"^ +(\w+) +: +(?:in|out) +\w+\([^)]*\baxes_c\b", shipped(_ENTITY).read_text(), re.M):
        left = root.find(f".//x:port[x:name='{name}']//x:left", _XML)
        left.text = str((int(left.text) + 1) // shipped_axes * n_axes - 1)
    return _HEADER + ElementTree.tostring(root, "unicode") + "\n"


def _numbers(root: ElementTree.Element) -> dict[str, ElementTree.Element]:
    """The elements that hold how many registers there are of a name, and how many bits of a field."""
    found = {}
    for register in root.iterfind(".//x:register", _XML):
        name = register.findtext("x:name", None, _XML)
        if (dim := register.find("x:dim", _XML)) is not None:
            found[name] = dim
        for field in register.iterfind("x:field", _XML):
            found[f"{name}.{field.findtext('x:name', None, _XML)}"] = field.find("x:bitWidth", _XML)
    return found
