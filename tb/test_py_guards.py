"""A guard that is off costs nothing: the netlist has the cells of one in which the VHDL knows no guard."""

import shutil

import pytest

from gravcomp_lab.synthesis.guards import OFF, STEPS, cells, without_guards
from gravcomp_lab.synthesis.verilog import rtl_sources
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


def test_choice_is_made():
    assert without_guards(CHOICE).strip() == "upset <= '0';"


@pytest.mark.parametrize("entity", ["gc_safety", pytest.param("gc_system", marks=pytest.mark.slow)])
def test_guard_that_is_off_costs_nothing(entity, tmp_path):
    shutil.copytree(RTL, tmp_path / "rtl")
    n_choices = 0
    for path in rtl_sources(tmp_path / "rtl"):
        text = path.read_text()
        bare = without_guards(text)
        n_choices += text.count(" else generate\n") - bare.count(" else generate\n")
        path.write_text(bare)
    assert n_choices >= 10
    off = cells(entity, OFF[entity], RTL, tmp_path / "off", "generic")
    assert off == cells(entity, OFF[entity], tmp_path / "rtl", tmp_path / "bare", "generic")


@pytest.mark.parametrize("what", STEPS)
def test_guard_that_is_on_costs_something(what, tmp_path):
    off = cells("gc_safety", OFF["gc_safety"], RTL, tmp_path / "off", "generic")
    on = cells("gc_safety", {**OFF["gc_safety"], **STEPS[what]}, RTL, tmp_path / "on", "generic")
    assert sum(on.values()) > sum(off.values())
