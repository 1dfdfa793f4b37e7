"""The quick functions of numeric_std (gravcomp.simulation.quick_ieee) return what GHDL's own do, to the bit."""

import subprocess

import numpy as np
import pytest

from gravcomp.simulation import quick_ieee

BENCH = """
library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
library std;
  use std.textio.all;

entity sums is
  generic (l_bits : positive; r_bits : positive);
end entity sums;

architecture sim of sums is
begin
  process is
    file     operands : text open read_mode is "operands.txt";
    variable line_v   : line;
    variable l        : std_ulogic_vector(1 to l_bits);
    variable r        : std_ulogic_vector(0 to r_bits - 1);
  begin
    while not endfile(operands) loop
      readline(operands, line_v);
      read(line_v, l);
      read(line_v, r);
      report to_string(signed(l) * signed(r)) & " " & to_string(signed(l) + signed(r)) & " "
        & to_string(signed(l) - signed(r)) & " " & to_string(unsigned(l) + unsigned(r)) & " "
        & to_string(unsigned(l) - unsigned(r)) & " " & to_string(-signed(l)) & " "
        & to_string(to_01(signed(l), 'X')) & " " & to_string(to_01(unsigned(r))) & " "
        & to_string(resize(signed(l), r'length)) & " " & to_string(resize(unsigned(l), r'length)) & " "
        & RELATIONS;
      if l'length <= 31 and r'length <= 31 then
        report integer'image(to_integer(signed(l))) & " " & integer'image(to_integer(unsigned(r))) & " "
          & WITH_INTEGERS;
      end if;
    end loop;
    wait;
  end process;
end architecture sim;
"""
RELATIONS = ("<", ">", "<=", ">=", "=", "/=")


def bench() -> str:
    """The bench, with every relation of both kinds, of vectors with each other and with integers, both ways round."""
    both = [f"to_string({k}(l) {o} {k}(r))" for k in ("signed", "unsigned") for o in RELATIONS]
    left, right = "to_integer({kind}(to_01({of})))", "{kind}({of})"
    mixed = [
        f"to_string({a.format(kind=kind, of='l')} {o} {b.format(kind=kind, of='r')})"
        for kind in ("signed", "unsigned")
        for o in RELATIONS
        for a, b in ((left, right), (right, left))
    ]
    joined = ' & " "\n          & '
    return BENCH.replace("WITH_INTEGERS", joined.join(mixed)).replace("RELATIONS", joined.join(both))


# About a limb of 14 bits, the core's, and about the widest that limbs hold, 98.
WIDTHS = [(1, 1), (2, 3), (14, 14), (15, 28), (18, 18), (24, 18), (25, 25), (31, 31), (25, 32), (32, 32), (40, 40)]
WIDTHS += [(98, 120), (120, 98), (99, 100)]


def operands(bits: int, n: int, rng: np.random.Generator) -> list[str]:
    """The extremes, 0, 1 and -1, random ones, and some with a bit that is neither 0 nor 1, or is so weakly."""
    low, high = "1" + "0" * (bits - 1), "0" + "1" * (bits - 1)
    words = [low, high, "0" * bits, "1" * bits, "0" * (bits - 1) + "1"]
    words += ["".join(rng.choice(list("01"), bits)) for _ in range(n)]
    return (
        words
        + ["".join(rng.choice(list("01LH"), bits)) for _ in range(n)]
        + ["".join(rng.choice(list("01UXZW-"), bits, p=[0.47, 0.48, *[0.01] * 5])) for _ in range(n)]
    )


def signed(word: str) -> int:
    return int(word, 2) - (int(word[0]) << len(word))


def answers(folder, options: list[str], generics: list[str]) -> list[str]:
    """What the bench reports, less where and when."""
    subprocess.run(["ghdl", "-a", "--std=08", *options, "sums.vhd"], cwd=folder, check=True)
    command = ["ghdl", "-r", "--std=08", *options, "sums", *generics]
    said = subprocess.run(command, cwd=folder, check=True, capture_output=True, text=True)
    return [line.split("note): ")[1] for line in (said.stdout + said.stderr).splitlines() if "note): " in line]


@pytest.fixture(scope="module")
def options(tmp_path_factory) -> list[str]:
    if not (options := quick_ieee.quick_ieee(tmp_path_factory.mktemp("ieee"))):
        pytest.skip("this GHDL keeps its own body of numeric_std")
    return options


@pytest.mark.parametrize(("l_bits", "r_bits"), WIDTHS)
def test_functions_return_what_those_of_ghdl_do(l_bits, r_bits, options, tmp_path):
    (tmp_path / "sums.vhd").write_text(bench())
    rng = np.random.default_rng(7)
    pairs = [(a, b) for a in operands(l_bits, 20, rng) for b in rng.choice(operands(r_bits, 20, rng), 12)]
    (tmp_path / "operands.txt").write_text("".join(f"{a} {b}\n" for a, b in pairs))
    generics = [f"-gl_bits={l_bits}", f"-gr_bits={r_bits}"]
    own = answers(tmp_path, [], generics)
    assert len(own) == len(pairs) * (2 if max(l_bits, r_bits) <= 31 else 1)
    assert answers(tmp_path, options, generics) == own
    words = [line.split() for line in own[:: len(own) // len(pairs)]]
    plain = [(a, b, line) for (a, b), line in zip(pairs, words, strict=True) if {*a, *b} <= {"0", "1"}]
    assert len(plain) > 100
    for a, b, (product, *_) in plain:
        assert signed(product) == signed(a) * signed(b)


def test_another_numeric_std_is_left_as_it_is():
    assert quick_ieee.quick_body("package body NUMERIC_STD is\nend package body NUMERIC_STD;\n") is None


def test_library_is_made_once(tmp_path, monkeypatch):
    if not (options := quick_ieee.quick_ieee(tmp_path)):
        pytest.skip("this GHDL keeps its own body of numeric_std")
    monkeypatch.setattr(quick_ieee, "_analyse", lambda *_: pytest.fail("made again"))
    assert quick_ieee.quick_ieee(tmp_path) == options
