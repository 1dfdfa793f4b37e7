"""The register map of gc_system of 8 axes, from IP-XACT; fewer axes use the same addresses."""

from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from gravcomp.errors import InputError
from gravcomp.shipped import shipped

REGISTERS_XML = shipped("rtl/registers/gc_registers.xml")
MOTION_XML = shipped("rtl/registers/gc_motion_registers.xml")
SPIRIT = "http://www.spiritconsortium.org/XMLSchema/SPIRIT/1685-2009"
_XML = {"x": SPIRIT}


@dataclass(frozen=True)
class Register:
    """count 32-bit registers from address (bytes) on, with their value after reset.

    fields: lowest bit and width of each. Masks: bits that can be read, that can be written, that hold what is written.
    """

    address: int
    count: int
    reset: int
    fields: dict[str, tuple[int, int]]
    readable: int
    writable: int
    holding: int

    def field(self, name: str, word: int) -> int:
        """The field's value in a word of this register."""
        low, width = self.fields[name]
        return word >> low & (1 << width) - 1


def read_registers(path: Path = REGISTERS_XML) -> dict[str, Register]:
    """The registers by name, in the order of their addresses. Raises InputError when the file is not as written."""
    try:
        elements = ElementTree.parse(path).getroot().iterfind(".//x:register", _XML)
        return {element.findtext("x:name", None, _XML): _register(element) for element in elements}
    except (OSError, ElementTree.ParseError, TypeError, ValueError) as error:
        raise InputError(f"{path}: no register map ({error}); write it with `make regs`") from error


def _register(element: ElementTree.Element) -> Register:
    fields, readable, writable, holding = {}, 0, 0, 0
    for field in element.iterfind("x:field", _XML):
        low, width = _integer(field, "x:bitOffset"), _integer(field, "x:bitWidth")
        fields[field.findtext("x:name", None, _XML)] = (low, width)
        mask, access = (1 << width) - 1 << low, field.findtext("x:access", None, _XML)
        if access.startswith("read"):
            readable |= mask
        if access != "read-only":
            writable |= mask
        if access == "read-write" and field.find("x:modifiedWriteValue", _XML) is None:
            holding |= mask
    address, count = _integer(element, "x:addressOffset"), _integer(element, "x:dim", "1")
    reset = _integer(element, "x:reset/x:value", "0")
    return Register(address, count, reset, fields, readable, writable, holding)


def _integer(element: ElementTree.Element, path: str, default: str | None = None) -> int:
    return int(element.findtext(path, default, _XML), 0)
