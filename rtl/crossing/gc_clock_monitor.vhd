-- SPDX-License-Identifier: MIT
--
-- Two unrelated clocks watch each other: a level goes to and fro between them (gc_crossing_pulse) as fast as they
-- allow, and each side counts its own clocks since it last came by.
--
--   core_alive  '0' from bus_limit_g + 2 clocks of bus_clk without a round trip on, until trips_c trips were in time
--   bus_lost    '1' from core_limit_g + 1 clocks of core_clk without an arrival on, until the next one;
--               and as long as core_alive is '0' again
--
-- So a core whose clock stood and runs again is told so before core_alive rises: its own registers, which slept, cannot
-- know. bus_lost is then '1' for at least 2 stages_g + 2 clocks of core_clk.
-- A wrong bit in any register here raises core_alive never, and lowers it for as many trips as a clock that stood, so
-- that the core is told; or it does nothing.
-- Limits: a round trip takes at most stages_g + 2 clocks of bus_clk and stages_g + 1 of core_clk. Each limit must be
-- longer than that in clocks of its own side, or a clock that runs counts as one that stands. A clock that became as
-- much slower counts as one that stands, too.
-- Reset: core_alive = '0' until the trips were made, however late a clock starts; bus_lost = '0' until then: nothing
-- was lost yet. If both clocks stop nothing is found.
-- Timing: all that crosses ends in a gc_synchronizer.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_clock_monitor is
  generic (
    -- Longest time without a sign of the other clock, clocks of the own side.
    bus_limit_g  : positive := 256;
    core_limit_g : positive := 256;
    -- Flip-flops against metastability in each direction, at least 2.
    stages_g     : positive := 2
  );
  port (
    bus_clk    : in    std_ulogic;
    -- Synchronous to bus_clk, active high.
    bus_rst    : in    std_ulogic;
    -- core_clk runs; two registers of bus_clk and one gate, of which no two change against each other.
    core_alive : out   std_ulogic;
    core_clk   : in    std_ulogic;
    -- Synchronous to core_clk, active high.
    core_rst   : in    std_ulogic;
    -- bus_clk stands, or core_clk stood.
    bus_lost   : out   std_ulogic
  );
end entity gc_clock_monitor;

architecture rtl of gc_clock_monitor is

  constant trips_c     : positive := 4;
  constant bus_bits_c  : positive := tree_depth(bus_limit_g + 1);
  constant core_bits_c : positive := tree_depth(core_limit_g + 1);

  signal trip         : std_ulogic;
  signal bus_expired  : std_ulogic;
  -- Round trips in a row that were in time, the first one at bit 1.
  signal trips        : std_ulogic_vector(1 to trips_c) := (others => '0');
  signal alive        : std_ulogic;
  signal alive_1      : std_ulogic := '0';
  signal arrival      : std_ulogic;
  signal core_expired : std_ulogic;
  signal told_alive   : std_ulogic;
  -- It was alive since reset.
  signal was_alive    : std_ulogic := '0';

begin

  -- Always another trip: in_ready is one clock per trip.
  i_trip : entity work.gc_crossing_pulse
    generic map (
      stages_g => stages_g
    )
    port map (
      in_clk    => bus_clk,
      in_valid  => '1',
      in_ready  => trip,
      out_clk   => core_clk,
      out_valid => arrival
    );

  -- The side of the bus

  i_bus_time : entity work.gc_timeout
    generic map (
      bits_g => bus_bits_c
    )
    port map (
      clk        => bus_clk,
      rst        => bus_rst,
      restart    => trip,
      cfg_clocks => to_unsigned(bus_limit_g, bus_bits_c),
      expired    => bus_expired,
      upset      => open
    );

  p_trips : process (bus_clk) is
  begin

    if rising_edge(bus_clk) then
      if trip = '1' then
        trips <= '1' & trips(1 to trips_c - 1);
      end if;
      -- It falls for one reason but these: a wrong bit. What fell for a clock only might never be seen by the core.
      alive_1 <= alive;
      if bus_expired = '1' or bus_rst = '1' or (alive_1 = '1' and alive = '0') then
        trips <= (others => '0');
      end if;
    end if;

  end process p_trips;

  -- The last two rise one after the other and fall together.
  alive <= trips(trips_c - 1) and trips(trips_c);
  core_alive <= alive;

  -- The side of the core

  i_core_time : entity work.gc_timeout
    generic map (
      bits_g => core_bits_c
    )
    port map (
      clk        => core_clk,
      rst        => core_rst,
      restart    => arrival,
      cfg_clocks => to_unsigned(core_limit_g, core_bits_c),
      expired    => core_expired,
      upset      => open
    );

  i_told : entity work.gc_synchronizer
    generic map (
      stages_g => stages_g
    )
    port map (
      clk           => core_clk,
      rst           => '0',
      async_data(0) => trips(trips_c),
      out_valid     => open,
      out_data(0)   => told_alive
    );

  p_was_alive : process (core_clk) is
  begin

    if rising_edge(core_clk) then
      was_alive <= was_alive or told_alive;
      if core_rst = '1' then
        was_alive <= '0';
      end if;
    end if;

  end process p_was_alive;

  bus_lost <= core_expired or (was_alive and not told_alive);

end architecture rtl;
