-- SPDX-License-Identifier: MIT
--
-- Simulation model of an incremental encoder: walks from its position to target, one quadrature edge at a time.
--
--   (a, b) = 00 10 11 01 for count modulo 4 = 0 1 2 3 (a leads b when counting up); z = '1' while count = index_count
--
-- A test sets target and waits for busy to fall; no Python runs per edge.
-- load moves the position by whole encoder cycles, next to load_count, without an edge on a or b: the two lowest bits
-- of count stay. To take a decoder anywhere: begin its homing with cfg_index_position = index_count = c, c modulo 4 the
-- decoder's index phase, load c - 8, then walk to c (at most ten edges).
-- Timing: the first edge comes one clock after target changes, the following ones clocks_per_edge apart, also across
-- reversals and a change of target. Wraps modulo 2**32 and takes the shorter way.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_encoder_model is
  port (
    clk             : in    std_ulogic;
    -- position to walk to, counts
    target          : in    signed(31 downto 0) := (others => '0');
    -- clocks from edge to edge, at least 1
    clocks_per_edge : in    unsigned(15 downto 0) := x"0001";
    -- preset, one clock
    load            : in    std_ulogic := '0';
    load_count      : in    signed(31 downto 0) := (others => '0');
    -- position of the index, counts
    index_count     : in    signed(31 downto 0) := (31 => '1', others => '0');
    a               : out   std_ulogic;
    b               : out   std_ulogic;
    z               : out   std_ulogic;
    -- true position, counts
    count           : out   signed(31 downto 0) := (others => '0');
    -- count differs from target
    busy            : out   std_ulogic
  );
end entity gc_encoder_model;

architecture sim of gc_encoder_model is

  signal wait_clocks : unsigned(15 downto 0) := (others => '0');

begin

  a <= count(0) xor count(1);
  b <= count(1);
  z <= '1' when count = index_count else '0';
  busy <= '1' when count /= target else '0';

  p_walk : process (clk) is

    variable distance_v : signed(31 downto 0);

  begin

    if rising_edge(clk) then
      distance_v := target - count;
      if wait_clocks > 0 then
        wait_clocks <= wait_clocks - 1;
      elsif load = '0' and distance_v /= 0 then
        count <= count + 1;
        if distance_v < 0 then
          count <= count - 1;
        end if;
        wait_clocks <= clocks_per_edge - 1;
      end if;
      if load = '1' then
        count <= load_count(31 downto 2) & count(1 downto 0);
      end if;
    end if;

  end process p_walk;

end architecture sim;
