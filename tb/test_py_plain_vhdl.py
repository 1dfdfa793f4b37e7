"""PeakRDL's VHDL made plain: what becomes of each construct, and which names are refused."""

import pytest

from gravcomp.core.vhdl.plain_vhdl import plain
from gravcomp.errors import InputError


def test_extended_identifiers_become_plain():
    text = "type \\a.b_t\\ is record\n    c : \\a.b.c_t\\;\nend record;\nsignal d : \\a.b_t\\(0 to 2); -- a.b\n"
    plain_text = "type a_b_t is record\n    c : a_b_c_t;\nend record;\nsignal d : a_b_t(0 to 2); -- a.b\n"
    assert plain(text) == plain_text


@pytest.mark.parametrize(
    "text",
    [
        "\\a.b_c\\ \\a_b.c\\",  # both a_b_c
        "\\a.b\\ \\A.B\\",  # plain names have no case
        "\\a.b\\ A_B",  # taken
        "\\a._b\\",  # two underscores
        "\\9.b\\",
        "\\a.b_\\",
    ],
)
def test_extended_identifiers_without_a_plain_name_are_refused(text):
    with pytest.raises(InputError, match="no plain name"):
        plain(text)


def test_libraries_are_the_two_in_use():
    text = "library ieee;\ncontext ieee.ieee_std_context;\nuse ieee.fixed_pkg.all;\n"
    assert plain(text) == "library ieee;\nuse ieee.std_logic_1164.all;\nuse ieee.numeric_std.all;\n"


def test_conditional_assignment_of_a_variable_becomes_an_if():
    text = "begin\n  a := '1' when b(c) = d else '0';\n  return a;\n"
    expected = "begin\n  if b(c) = d then\n      a := '1';\n  else\n      a := '0';\n  end if;\n  return a;\n"
    assert plain(text) == expected
