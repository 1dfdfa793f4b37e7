-- SPDX-License-Identifier: MIT
--
-- Incremental encoder interface of one axis: synchroniser, glitch filter, x4 decoding, index, speed.
--
--   phase = 0 1 2 3 <=>  (a, b) = 00 10 11 01;  count := count + 1, - 1 for phase + 1, - 1 modulo 4 (a leads b: up)
--
-- pins a, b, z -> signed 32-bit count (encoder counts after x4 decoding) and speed (see gc_speed_meter).
-- Latency: sync_stages_g + filter_samples_g + 1 clocks from the first clock edge that samples a pin's new level (that
-- edge included) to count, direction and sts_*; 3 clocks more to speed_*.
-- Start: count_valid rises, with count = 0, once both levels are known; the state found then is the start, no edge is
-- invented. It takes sync_stages_g + filter_samples_g + 1 clocks after reset on quiet pins.
-- Limit speed: each level of a and b must last max(filter_samples_g, 2) clock edges; a and b must not change between
-- the same two: 2 counts per max(filter_samples_g, 2) clocks. Pins asynchronous to clk: leave one clock more.
-- Beyond the limit no count is lost silently: pulses that the filter drops set sts_glitch, simultaneous changes
-- set sts_illegal, as long as the encoder accelerates through the limit and doesn't jump past it within a clock.
-- Illegal transition (a and b change at once): count stays, sts_illegal is set, sts_referenced falls: two counts are
-- missing in an unknown direction until the next homing.
-- Overflow: count wraps modulo 2**32 (2**31 - 1 is followed by -2**31) without a flag.
-- Index: homing is armed by a rising cfg_home_enable (which clears sts_referenced) and disarmed by a low one. The first
-- clock with z = '1' in phase index_phase_g sets count to cfg_index_position and sts_referenced, and disarms. That is
-- one quarter of an encoder cycle, the same from both directions and whatever the width of z, provided that z covers
-- that phase of just one cycle (gated index, or ungated up to one cycle wide). Later indices change nothing.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_quad_decoder is
  generic (
    -- flip-flops per pin against metastability, at least 2
    sync_stages_g    : positive := 2;
    -- clocks that a level must last, 0 = no filter
    filter_samples_g : natural := 4;
    -- phase in which the index is taken, 0 .. 3; 2 is a = b = '1'
    index_phase_g    : natural := 2;
    -- clocks without an edge that count as standstill, 1 .. 2**29 - 1
    speed_timeout_g  : positive := 10_000_000
  );
  port (
    clk                : in    std_ulogic;
    rst                : in    std_ulogic;
    -- encoder pins, asynchronous
    a                  : in    std_ulogic;
    b                  : in    std_ulogic;
    z                  : in    std_ulogic;
    -- a rising edge arms homing, '0' disarms it
    cfg_home_enable    : in    std_ulogic;
    -- count at the index, encoder counts
    cfg_index_position : in    signed(31 downto 0);
    -- '1' clears sts_illegal and sts_glitch; an event in the same clock wins
    cfg_clear          : in    std_ulogic;
    -- count is meaningful; a level, high until reset
    count_valid        : out   std_ulogic := '0';
    -- encoder counts, two's complement
    count              : out   signed(31 downto 0) := (others => '0');
    -- direction of the last count, '1' = up
    direction          : out   std_ulogic := '0';
    -- speed_period is measured, or the axis stands still
    speed_valid        : out   std_ulogic;
    -- no edge for speed_timeout_g clocks
    speed_zero         : out   std_ulogic;
    -- clocks per 4 counts, negative when counting down; 2**31 - 1 when still or not measured
    speed_period       : out   signed(31 downto 0);
    -- count refers to the index
    sts_referenced     : out   std_ulogic := '0';
    -- a and b changed at once since the last cfg_clear: counts are missing
    sts_illegal        : out   std_ulogic := '0';
    -- the filter dropped a pulse of a or b since the last cfg_clear: noise, or the encoder is too fast
    sts_glitch         : out   std_ulogic := '0'
  );
end entity gc_quad_decoder;

architecture rtl of gc_quad_decoder is

  signal synced_valid  : std_ulogic;
  signal synced        : std_ulogic_vector(2 downto 0);
  -- bits z, b, a
  signal valid         : std_ulogic_vector(2 downto 0);
  signal level         : std_ulogic_vector(2 downto 0);
  signal dropped       : std_ulogic_vector(2 downto 0);
  signal phase         : unsigned(1 downto 0);
  signal phase_1       : unsigned(1 downto 0) := (others => '0');
  signal home_enable_1 : std_ulogic := '0';
  signal armed         : std_ulogic := '0';
  signal step_valid    : std_ulogic := '0';
  signal step_lost     : std_ulogic := '0';

begin

  assert index_phase_g <= 3
    report "gc_quad_decoder: need index_phase_g in 0 .. 3, got " & integer'image(index_phase_g)
    severity failure;

  i_synchronizer : entity work.gc_synchronizer
    generic map (
      width_g  => 3,
      stages_g => sync_stages_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      async_data => z & b & a,
      out_valid  => synced_valid,
      out_data   => synced
    );

  g_filter : for i in synced'range generate

    i_glitch_filter : entity work.gc_glitch_filter
      generic map (
        samples_g => filter_samples_g
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => synced_valid,
        in_level    => synced(i),
        out_valid   => valid(i),
        out_level   => level(i),
        out_dropped => dropped(i)
      );

  end generate g_filter;

  phase <= level(1) & (level(0) xor level(1));

  p_decode : process (clk) is

    variable change_v : unsigned(1 downto 0);

  begin

    if rising_edge(clk) then
      step_valid <= '0';
      step_lost <= '0';

      if cfg_clear = '1' then
        sts_illegal <= '0';
        sts_glitch <= '0';
      end if;
      if dropped(0) = '1' or dropped(1) = '1' then
        sts_glitch <= '1';
      end if;

      if valid(0) = '1' and valid(1) = '1' then
        count_valid <= '1';
        phase_1 <= phase;
      end if;

      change_v := phase - phase_1;
      if count_valid = '1' then
        -- no `case` over all values: GHDL 2.0.0 makes latches of it in Verilog
        if change_v = 1 then
          count <= count + 1;
          direction <= '1';
          step_valid <= '1';
        elsif change_v = 3 then
          count <= count - 1;
          direction <= '0';
          step_valid <= '1';
        elsif change_v = 2 then
          sts_illegal <= '1';
          sts_referenced <= '0';
          step_lost <= '1';
        end if;
      end if;

      -- after the count: the index says where the axis is, whatever the step that led there
      home_enable_1 <= cfg_home_enable;
      if cfg_home_enable = '1' then
        if home_enable_1 = '0' then
          armed <= '1';
          sts_referenced <= '0';
        elsif armed = '1' and count_valid = '1' and valid(2) = '1' and level(2) = '1' and phase = index_phase_g then
          armed <= '0';
          count <= cfg_index_position;
          sts_referenced <= '1';
        end if;
      end if;

      if rst = '1' then
        count_valid <= '0';
        count <= (others => '0');
        direction <= '0';
        sts_referenced <= '0';
        sts_illegal <= '0';
        sts_glitch <= '0';
        home_enable_1 <= '0';
        armed <= '0';
        step_valid <= '0';
        step_lost <= '0';
      end if;
    end if;

  end process p_decode;

  i_speed_meter : entity work.gc_speed_meter
    generic map (
      timeout_g => speed_timeout_g
    )
    port map (
      clk          => clk,
      rst          => rst,
      step_valid   => step_valid,
      step_up      => direction,
      step_lost    => step_lost,
      speed_valid  => speed_valid,
      speed_zero   => speed_zero,
      speed_period => speed_period
    );

end architecture rtl;
