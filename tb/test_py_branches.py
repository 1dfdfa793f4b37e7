"""Conditions of VHDL that note what they were: which ones, and that a simulation of them tells the branches taken."""

import shutil
import subprocess

from gravcomp_lab.mutation.branches import SEEN, Condition, instrument, markdown

VHDL = """\
entity gc_x is
end entity gc_x;

architecture rtl of gc_x is

  signal n : natural := 0;

  function f (n : natural) return natural is
  begin
    if n = 0 then
      return 1;
    end if;
    return n;
  end function f;

begin

  g_n : if true generate
    n <= n + 1 after 1 ns when n < 3 else n;  -- if n = 8 then
  end generate g_n;

  p_x : process (n) is
  begin
    if n = 1 then
      null;
    elsif n > 9 then
      null;
    end if;
  end process p_x;

end architecture rtl;
"""


def test_branches_of_a_simulation_are_noted(tmp_path):
    rtl, out = tmp_path / "rtl", tmp_path / "out"
    rtl.mkdir()
    (rtl / "gc_x.vhd").write_text(VHDL)
    (rtl / "sources.f").write_text("gc_x.vhd\n")
    conditions = instrument(rtl, out)
    assert [c.text for c in conditions] == ["n < 3", "n = 1", "n > 9"]
    assert conditions[0] == Condition("gc_x.vhd", 19, "n < 3")
    for arguments in (["-a", "--std=08", "gc_branch_pkg.vhd", "gc_x.vhd"], ["--elab-run", "--std=08", "gc_x"]):
        subprocess.run([shutil.which("ghdl"), *arguments], cwd=out, check=True)
    noted = set((out / SEEN).read_text().split("\n")) - {""}
    # n = 0 is gone when time passes; 10 is never reached.
    assert noted == {"0 true", "0 false", "1 true", "1 false", "2 false"}


def test_what_was_never_taken_is_listed_with_its_reason():
    conditions = [Condition("gc_x.vhd", 7, "a = '1'"), Condition("gc_x.vhd", 9, "b = '1'")]
    table = markdown(conditions, {0: {True, False}, 1: {True}}, {("gc_x.vhd", "b = '1'", False): "never"})
    assert "| gc_x.vhd | 4 | 1 | 75.0 % |" in table
    assert "| gc_x.vhd:9 | `b = '1'` | false | never |" in table
    assert "not explained" in markdown(conditions, {0: {True, False}, 1: {True}}, {})
