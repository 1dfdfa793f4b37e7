"""A fault can be planted at every output port, and a proof sees those of a seeded sample."""

import numpy as np
import pytest

from gravcomp_lab.formal.claims import CLAIMS
from gravcomp_lab.mutation.ports import Port, output_ports, plant, try_port
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
    assert Port("gc_tick", "sts_missed", "unsigned(31 downto 0)", ":= (others => '0')") in PORTS
    assert Port("gc_loader", "memory", "memory_t") in PORTS


def test_fault_is_at_the_port_alone(tmp_path):
    flag, words = Port("gc_x", "flag", "std_ulogic", ":= '0'"), Port("gc_x", "words", "signed(7 downto 0)")
    faulty = plant(VHDL, flag, {})
    assert "signal flag_sound : std_ulogic := '0';" in faulty
    assert "flag     => flag_sound," in faulty
    assert "flag <= not flag_sound;" in faulty
    faulty = plant(VHDL, words, {})
    assert "words(1) => words_sound(1)" in faulty
    assert "words(words_sound'low) <= not words_sound(words_sound'low);" in faulty


def test_fault_of_a_record_is_in_its_first_field():
    port = Port("gc_x", "flag", "a_t")
    faulty = plant(VHDL, port, {"a_t": ("b", "c_t"), "c_t": ("d", "std_ulogic")})
    assert "flag.b.d <= not flag_sound.b.d;" in faulty


@pytest.mark.parametrize("k", range(3))
def test_fault_at_a_port_is_seen_by_a_proof(k):
    quick = [port for port in PORTS if port.entity in QUICK]
    assert {port.entity for port in quick} <= {claim.entity for claim in CLAIMS}
    port = quick[np.random.default_rng(7).permutation(len(quick))[k]]
    found = try_port(port, ROOT)
    assert found.tool == "proof", found
