"""A fault can be planted at every output port, and a proof sees those of a seeded sample."""

import shutil

import numpy as np
import pytest

from gravcomp_lab.formal.claims import CLAIMS
from gravcomp_lab.mutation import ports
from gravcomp_lab.mutation.ports import Found, OutputPort, PortVerdicts, markdown, output_ports, plant, try_port
from runner import ROOT, RTL

PORTS = output_ports(RTL)
# What is proven in a second or two.
QUICK = ("gc_tick", "gc_speed_meter", "gc_crossing_pulse", "gc_crossing_bus", "gc_loader", "gc_glitch_filter")

VHDL = """\
entity gc_x is
  port (
    clk   : in    std_ulogic;
    -- a : out nothing;
    flag  : out   std_ulogic := '0';
    words : out   signed(7 downto 0)
  );
end entity gc_x;

architecture rtl of gc_x is

begin

  i_x : entity work.gc_y
    port map (
      flag     => flag,
      words(1) => words(1)
    );

end architecture rtl;
"""


def test_ports_are_those_of_the_entities():
    assert {"gc_system", "gc_core", "gc_registers"} <= {port.entity for port in PORTS}
    assert len(set(PORTS)) == len(PORTS) > 150
    assert OutputPort("gc_tick", "sts_missed", "unsigned(31 downto 0)", ":= (others => '0')") in PORTS
    assert OutputPort("gc_loader", "memory", "memory_t") in PORTS


def test_fault_is_at_the_port_alone(tmp_path):
    flag, words = OutputPort("gc_x", "flag", "std_ulogic", ":= '0'"), OutputPort("gc_x", "words", "signed(7 downto 0)")
    faulty = plant(VHDL, flag, {})
    assert "signal flag_sound : std_ulogic := '0';" in faulty
    assert "flag     => flag_sound," in faulty
    assert "flag <= not flag_sound;" in faulty
    faulty = plant(VHDL, words, {})
    assert "words(1) => words_sound(1)" in faulty
    assert "words(words_sound'low) <= not words_sound(words_sound'low);" in faulty


def test_fault_of_a_record_is_in_its_first_field():
    port = OutputPort("gc_x", "flag", "a_t")
    faulty = plant(VHDL, port, {"a_t": ("b", "c_t"), "c_t": ("d", "std_ulogic")})
    assert "flag.b.d <= not flag_sound.b.d;" in faulty


@pytest.mark.parametrize("k", range(3))
def test_fault_at_a_port_is_seen_by_a_proof(k):
    quick = [port for port in PORTS if port.entity in QUICK]
    assert {port.entity for port in quick} <= {claim.entity for claim in CLAIMS}
    port = quick[np.random.default_rng(7).permutation(len(quick))[k]]
    found = try_port(port, ROOT)
    assert found.tool == "proof", found


def test_verdict_holds_until_what_it_rests_on_changes(tmp_path):
    """The entity and the checker of a proof, or the test: another file changes nothing."""
    for name in ("rtl", "tb"):
        shutil.copytree(ROOT / name, tmp_path / name)
    proof, test = PORTS[1], PORTS[0]
    kept = [Found(proof.entity, proof.name, "proof", "tick: reset_clears"),
            Found(test.entity, test.name, "simulation: equality with the twin",
                  "test_rtl_tick.py::test_x")]  # fmt: skip
    for found in kept:
        PortVerdicts(tmp_path / "ports.csv", tmp_path).keep(found)

    def known() -> list[Found | None]:
        verdicts = PortVerdicts(tmp_path / "ports.csv", tmp_path)
        return [verdicts.known(proof), verdicts.known(test)]

    assert known() == kept
    (tmp_path / "tb" / "test_rtl_delay.py").write_text("")
    assert known() == kept
    (tmp_path / "tb" / "formal" / "tick.sv").write_text("")
    assert known() == [None, kept[1]]
    (tmp_path / "tb" / "test_rtl_tick.py").write_text("")
    assert known() == [None, None]


def test_simulation_that_does_not_end_has_found_nothing(monkeypatch):
    port = OutputPort("gc_delay", "out_data", "std_ulogic_vector(bits_g - 1 downto 0)")
    for result, tool in (("time-out", ""), ("survived", ""), ("caught", "simulation: equality with the twin")):
        monkeypatch.setattr(ports, "run_tests", lambda *_, result=result: (result, "test_rtl_delay.py::test_x"))
        found = try_port(port, ROOT)
        assert found.tool == tool
        assert ("**nothing**" in markdown([found], 1)) == (tool == "")
