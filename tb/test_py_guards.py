"""A guard that is off costs nothing: the circuit is that of VHDL which knows no guard."""

import re
import shutil

import pytest

from gravcomp_lab.synthesis.guards import OFF, STEPS, cells, without_guards
from gravcomp_lab.synthesis.verilog import rtl_sources, to_verilog
from runner import RTL

CHOICE = """\
  g_guard : if guard_g generate

    g_word : for i in 0 to 3 generate

      g_there : if i > 1 generate
        bad(i) <= '1';
      else generate
        bad(i) <= '0';
      end generate g_there;

    end generate g_word;

  else generate
    upset <= '0';
  end generate g_guard;
"""


def circuit(verilog: str) -> str:
    """Verilog of GHDL with its names of values, which have running numbers, in the order in which they occur: what is
    one circuit is then one text, and has one netlist."""
    names: dict[str, str] = {}
    code = re.sub(r"\s*//.*", "", verilog)
    return re.sub(r"\bn\d+(?:_\w+)?\b", lambda name: names.setdefault(name[0], f"x{len(names)}"), code)


def test_circuit_is_that_of_its_values_whatever_their_numbers():
    one = "assign n1_o = a & b; // 7:3\nassign n2_o = n1_o | a;"
    assert circuit(one) == circuit(one.replace("n1_o", "n5_o").replace("7:3", "9:1"))
    assert circuit(one) != circuit(one.replace("n1_o | a", "n2_o | a"))


def test_choice_is_made():
    assert without_guards(CHOICE).strip() == "upset <= '0';"


@pytest.mark.parametrize("entity", ["gc_safety", "gc_system"])
def test_guard_that_is_off_costs_nothing(entity, tmp_path):
    shutil.copytree(RTL, tmp_path / "rtl")
    n_choices = 0
    for path in rtl_sources(tmp_path / "rtl"):
        text = path.read_text()
        bare = without_guards(text)
        n_choices += text.count(" else generate\n") - bare.count(" else generate\n")
        path.write_text(bare)
    assert n_choices >= 10
    off, bare = (
        to_verilog(rtl_sources(rtl), entity, OFF[entity], tmp_path / f"{name}.v").read_text()
        for name, rtl in (("off", RTL), ("bare", tmp_path / "rtl"))
    )
    assert circuit(off) == circuit(bare)


@pytest.mark.parametrize("what", STEPS)
def test_guard_that_is_on_costs_something(what, tmp_path):
    off = cells("gc_safety", OFF["gc_safety"], RTL, tmp_path / "off", "generic")
    on = cells("gc_safety", {**OFF["gc_safety"], **STEPS[what]}, RTL, tmp_path / "on", "generic")
    assert sum(on.values()) > sum(off.values())
