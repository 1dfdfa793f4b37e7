-- SPDX-License-Identifier: MIT
--
-- Incremental encoder interface of one axis: synchroniser, glitch filter, x4 decoding, index, speed, lost counts.
--
--   phase = 0 1 2 3 <=>  (a, b) = 00 10 11 01;  count := count + 1, - 1 for phase + 1, - 1 modulo 4 (a leads b: up)
--
-- pins a, b, z -> signed 32-bit count (encoder counts after x4 decoding) and speed (see gc_speed_meter).
-- Latency: sync_stages_g + filter_samples_g + 1 clocks from the first clock edge that samples a pin's new level (that
-- edge included) to count, direction and sts_*; 3 clocks more to speed_*. Lost counts: see there.
-- Start: count_valid rises, with count = 0, once both levels are known; the state found then is the start, no edge is
-- invented. It takes sync_stages_g + filter_samples_g + 1 clocks after reset on quiet pins.
-- Limit speed: each level of a and b must last max(filter_samples_g, 2) clock edges; a and b must not change between
-- the same two: 2 counts per max(filter_samples_g, 2) clocks. Pins asynchronous to clk: leave one clock more.
-- Lost counts set sts_illegal, and sts_referenced falls, until the next homing:
-- - a and b, as filtered, change at once; in the clock in which count would have changed, and count stays;
-- - the filter dropped levels that were counts, as beyond the limit speed: exact, see gc_count_check; 2 clocks after
--   the count that is wrong. sts_glitch alone: what was dropped was no count;
-- - a mark of the index in the wrong place, or missing: see gc_index_check; 4 clocks after the count;
-- - edges of one channel only, as a broken wire makes them: see gc_edge_watch; 2 clocks after the last of them;
-- - error = '1': sync_stages_g + 1 clocks after its first sample, as long as it is high.
-- Overflow: count wraps modulo 2**32 (2**31 - 1 is followed by -2**31) without a flag.
-- Index: homing begins with a rising cfg_home_enable (which clears sts_referenced) and ends with a low one. It is armed
-- by z = '0' in phase index_phase_g: a z that is stuck high is no reference; pull z down, so that an open wire is none
-- either. The first clock with z = '1' in that phase then sets count to cfg_index_position and sts_referenced. That is
-- one quarter of an encoder cycle, the same from both directions and whatever the width of z, provided that z covers
-- that phase of just one cycle (gated index, or ungated up to one cycle wide). An axis that rests on its index has to
-- leave it by a cycle and come back. Later indices are compared with the count and change nothing.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_quad_decoder is
  generic (
    -- flip-flops per pin against metastability, at least 2
    sync_stages_g     : positive := 2;
    -- clocks that a level must last, 0 = no filter
    filter_samples_g  : natural := 4;
    -- phase in which the index is taken, 0 .. 3; 2 is a = b = '1'
    index_phase_g     : natural := 2;
    -- clocks without an edge that count as standstill, 1 .. 2**29 - 1
    speed_timeout_g   : positive := 10_000_000;
    -- clocks from count to count below which the axis cannot turn on the spot; see gc_edge_watch
    reversal_clocks_g : positive := 250;
    -- clocks from edge to edge of one channel that may go on for ever; see gc_edge_watch
    dither_clocks_g   : positive := 40
  );
  port (
    clk                : in    std_ulogic;
    rst                : in    std_ulogic;
    -- encoder pins, asynchronous
    a                  : in    std_ulogic;
    b                  : in    std_ulogic;
    z                  : in    std_ulogic;
    -- error output of a fail-safe receiver, asynchronous: '1' means that a, b and z cannot be trusted
    error              : in    std_ulogic := '0';
    -- a rising edge begins homing, '0' ends it
    cfg_home_enable    : in    std_ulogic;
    -- count at the index, encoder counts
    cfg_index_position : in    signed(31 downto 0);
    -- counts from index to index, a multiple of 4; 0 = there is one
    cfg_index_period   : in    unsigned(31 downto 0) := (others => '0');
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
    -- counts were lost since the last cfg_clear, or cannot be trusted
    sts_illegal        : out   std_ulogic := '0';
    -- the filter dropped a pulse of a or b since the last cfg_clear: noise
    sts_glitch         : out   std_ulogic := '0'
  );
end entity gc_quad_decoder;

architecture rtl of gc_quad_decoder is

  signal synced_valid  : std_ulogic;
  -- bits error, z, b, a
  signal synced        : std_ulogic_vector(3 downto 0);
  signal valid         : std_ulogic_vector(2 downto 0);
  signal level         : std_ulogic_vector(2 downto 0);
  signal sample        : std_ulogic_vector(2 downto 0);
  signal dropped       : std_ulogic_vector(2 downto 0);
  signal levels_valid  : std_ulogic;
  signal phase         : unsigned(1 downto 0);
  signal phase_1       : unsigned(1 downto 0) := (others => '0');
  -- with count: the levels are those of the index phase, z
  signal at_index_1    : std_ulogic := '0';
  signal z_1           : std_ulogic := '0';
  signal home_enable_1 : std_ulogic := '0';
  signal homing        : std_ulogic := '0';
  signal armed         : std_ulogic := '0';
  signal homed         : std_ulogic := '0';
  signal step_valid    : std_ulogic := '0';
  signal step_illegal  : std_ulogic := '0';
  signal step_lost     : std_ulogic := '0';
  signal lost          : std_ulogic;
  signal lost_cycle    : std_ulogic;
  signal lost_index    : std_ulogic;
  signal broken        : std_ulogic;

begin

  assert index_phase_g <= 3
    report "gc_quad_decoder: need index_phase_g in 0 .. 3, got " & integer'image(index_phase_g)
    severity failure;

  i_synchronizer : entity work.gc_synchronizer
    generic map (
      width_g  => 4,
      stages_g => sync_stages_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      async_data => error & z & b & a,
      out_valid  => synced_valid,
      out_data   => synced
    );

  g_filter : for i in level'range generate

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
        out_sample  => sample(i),
        out_dropped => dropped(i)
      );

  end generate g_filter;

  phase <= level(1) & (level(0) xor level(1));
  levels_valid <= valid(0) and valid(1);
  lost <= lost_cycle or lost_index or broken or (synced_valid and synced(3));

  p_decode : process (clk) is

    variable change_v : unsigned(1 downto 0);

  begin

    if rising_edge(clk) then
      step_valid <= '0';
      step_illegal <= '0';
      step_lost <= lost;
      homed <= '0';

      if cfg_clear = '1' then
        sts_illegal <= '0';
        sts_glitch <= '0';
      end if;
      if dropped(0) = '1' or dropped(1) = '1' then
        sts_glitch <= '1';
      end if;

      if levels_valid = '1' then
        count_valid <= '1';
        phase_1 <= phase;
      end if;
      at_index_1 <= '0';
      if phase = index_phase_g then
        at_index_1 <= '1';
      end if;
      z_1 <= valid(2) and level(2);

      change_v := phase - phase_1;
      if count_valid = '1' then
        -- 1, or 3, which is -1: one adder for both
        if change_v(0) = '1' then
          count <= count + signed(change_v);
          direction <= not change_v(1);
          step_valid <= '1';
        elsif change_v = 2 then
          step_illegal <= '1';
          step_lost <= '1';
        end if;
      end if;
      if lost = '1' or (count_valid = '1' and change_v = 2) then
        sts_illegal <= '1';
        sts_referenced <= '0';
      end if;

      -- after the count: the index says where the axis is, whatever the step that led there
      home_enable_1 <= cfg_home_enable;
      if cfg_home_enable = '0' then
        homing <= '0';
        armed <= '0';
      elsif home_enable_1 = '0' then
        homing <= '1';
        armed <= '0';
        sts_referenced <= '0';
      elsif homing = '1' and count_valid = '1' and valid(2) = '1' and phase = index_phase_g then
        if level(2) = '0' then
          armed <= '1';
        elsif armed = '1' then
          homing <= '0';
          homed <= '1';
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
        homing <= '0';
        homed <= '0';
        step_valid <= '0';
        step_illegal <= '0';
        step_lost <= '0';
      end if;
    end if;

  end process p_decode;

  i_count_check : entity work.gc_count_check
    port map (
      clk       => clk,
      rst       => rst,
      in_valid  => count_valid,
      in_sample => sample(1 downto 0),
      in_level  => level(1 downto 0),
      out_lost  => lost_cycle
    );

  -- z may bounce, and a level of a or b end late, by as much as the filter takes
  i_index_check : entity work.gc_index_check
    generic map (
      mark_clocks_g => 4 * filter_samples_g + 4
    )
    port map (
      clk              => clk,
      rst              => rst,
      step_valid       => step_valid,
      step_up          => direction,
      in_home          => homed,
      in_referenced    => sts_referenced,
      in_phase         => at_index_1,
      in_z             => z_1,
      cfg_index_period => cfg_index_period,
      out_lost         => lost_index
    );

  i_edge_watch : entity work.gc_edge_watch
    generic map (
      reversal_clocks_g => reversal_clocks_g,
      dither_clocks_g   => dither_clocks_g
    )
    port map (
      clk          => clk,
      rst          => rst,
      step_valid   => step_valid,
      step_up      => direction,
      step_illegal => step_illegal,
      out_broken   => broken
    );

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
