"""VHDL as PeakRDL writes it, in the subset that more tools read. The meaning does not change:

* extended identifiers become plain ones. PeakRDL names the type of a field by its path, with dots, which VHDL allows
  between backslashes only; VUnit's parser does not read those.
* a context and fixed_pkg give way to the two packages that are in use.
* a conditional assignment of a variable becomes an if: Quartus Prime Standard and Vivado's simulator refuse it.
"""

import re

from gravcomp.errors import InputError

_CONTEXT = "context ieee.ieee_std_context;\n"
_FIXED = "use ieee.fixed_pkg.all;\n"
_LIBRARIES = "use ieee.std_logic_1164.all;\nuse ieee.numeric_std.all;\n"
_CHOICE = re.compile(r"^( *)(\w+) := ([^;]*?) when ([^;]*?) else ([^;]*?);\n", re.M)


def plain(text: str) -> str:
    """The same design. Raises InputError when two names would become one, or a plain name is taken or no identifier."""
    text = text.replace(_CONTEXT, _LIBRARIES).replace(_FIXED, "")
    text = _CHOICE.sub(r"\1if \4 then\n\1    \2 := \3;\n\1else\n\1    \2 := \5;\n\1end if;\n", text)
    return _plain_names(text)


def _plain_names(text: str) -> str:
    taken = {name.lower() for name in re.findall(r"\w+", re.sub(r"\\.*?\\", "", text))}
    names = {extended: extended.replace(".", "_") for extended in set(re.findall(r"\\(.*?)\\", text))}
    for extended, name in names.items():
        others = [other for other in names if other != extended and names[other].lower() == name.lower()]
        if others or name.lower() in taken or not re.fullmatch(r"[A-Za-z](_?[A-Za-z0-9])*", name):
            raise InputError(f"\\{extended}\\: no plain name for it; rename the register or field in gc_registers.rdl")
    return re.sub(r"\\(.*?)\\", lambda match: names[match[1]], text)
