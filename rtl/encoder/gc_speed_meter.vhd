-- SPDX-License-Identifier: MIT
--
-- Speed of a quadrature encoder by period measurement: the clocks that the last four counts took.
--
--   v [counts/s] = 4 f_clk / speed_period
--
-- Four counts in one direction lead from an edge to the next edge of the same kind (channel and polarity), so duty
-- cycle and phase errors of the encoder cancel. The period is exact to less than one clock (two edges, each seen at the
-- next clock): relative error below 1 / speed_period. It is the mean speed over that period, known at the edge that
-- ends it. A division is left out on purpose: a limiter compares periods, and whoever needs v divides at its own rate.
--
-- Slowing down: as soon as the next edge is overdue, speed_period grows with the clocks since the edge four counts
-- before the awaited one, which bounds |v| from above before the edge arrives.
-- Standstill: no edge for timeout_g clocks, |v| < f_clk / timeout_g. speed_zero = '1', speed_valid = '1'.
-- Reversal, illegal transition, start: speed_valid = '0' until five edges in one direction have been seen.
-- speed_period is 2**31 - 1 (slower than any measured speed) at standstill and while speed_valid = '0'.
-- Overflow: none. Intervals never exceed timeout_g, so periods never exceed 4 timeout_g < 2**31.
-- Latency: 3 clocks from step_valid to speed_*.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
  use ieee.math_real.all;

entity gc_speed_meter is
  generic (
    -- clocks without an edge that count as standstill, 1 .. 2**29 - 1
    timeout_g : positive := 10_000_000
  );
  port (
    clk          : in    std_ulogic;
    rst          : in    std_ulogic;
    -- one count happened, one clock
    step_valid   : in    std_ulogic;
    -- direction of that count, '1' = up
    step_up      : in    std_ulogic;
    -- illegal transition, one clock: counts were lost
    step_lost    : in    std_ulogic;
    speed_valid  : out   std_ulogic := '0';
    speed_zero   : out   std_ulogic := '0';
    -- clocks per 4 counts, negative when counting down
    speed_period : out   signed(31 downto 0) := (31 => '0', others => '1')
  );
end entity gc_speed_meter;

architecture rtl of gc_speed_meter is

  -- the edge that ends a period of four counts is the fifth
  constant edges_c   : positive := 5;
  constant slowest_c : signed(31 downto 0) := (31 => '0', others => '1');

  -- holds the longest period, 4 timeout_g: now may wrap, a difference that short is exact
  constant width_c : positive := integer(ceil(log2(4.0 * real(timeout_g) + 1.0)));

  subtype clocks_t is unsigned(width_c - 1 downto 0);

  type stamps_t is array (1 to edges_c - 1) of clocks_t;

  signal now   : clocks_t := (others => '0');
  signal stamp : stamps_t := (others => (others => '0'));
  signal idle  : natural range 0 to timeout_g := 0;

  signal edges_1   : natural range 0 to edges_c := 0;
  signal up_1      : std_ulogic := '0';
  signal step_1    : std_ulogic := '0';
  signal zero_1    : std_ulogic := '0';
  signal elapsed_1 : clocks_t := (others => '0');

  signal valid_2  : std_ulogic := '0';
  signal up_2     : std_ulogic := '0';
  signal zero_2   : std_ulogic := '0';
  signal period_2 : clocks_t := (others => '0');

begin

  assert timeout_g < 2 ** 29
    report "gc_speed_meter: need timeout_g < 536870912, got " & integer'image(timeout_g)
    severity failure;

  p_measure : process (clk) is
  begin

    if rising_edge(clk) then
      -- stage 1: edges in one direction, clocks since the fourth-last of them
      now <= now + 1;
      elapsed_1 <= now - stamp(stamp'high);
      step_1 <= step_valid;
      if step_valid = '1' then
        stamp <= now & stamp(1 to stamp'high - 1);
        idle <= 0;
        zero_1 <= '0';
        up_1 <= step_up;
        if edges_1 = 0 or step_up /= up_1 then
          edges_1 <= 1;
        elsif edges_1 < edges_c then
          edges_1 <= edges_1 + 1;
        end if;
      elsif step_lost = '1' then
        idle <= 0;
        zero_1 <= '0';
        edges_1 <= 0;
      elsif idle = timeout_g - 1 then
        zero_1 <= '1';
        edges_1 <= 0;
      else
        idle <= idle + 1;
      end if;

      -- stage 2: measured at an edge, stretched while the next one is overdue
      valid_2 <= '0';
      if edges_1 = edges_c then
        valid_2 <= '1';
      end if;
      up_2 <= up_1;
      zero_2 <= zero_1;
      if step_1 = '1' or elapsed_1 > period_2 then
        period_2 <= elapsed_1;
      end if;

      -- stage 3: sign
      speed_valid <= valid_2 or zero_2;
      speed_zero <= zero_2;
      if valid_2 = '0' then
        speed_period <= slowest_c;
      elsif up_2 = '1' then
        speed_period <= signed(resize(period_2, 32));
      else
        speed_period <= -signed(resize(period_2, 32));
      end if;

      if rst = '1' then
        edges_1 <= 0;
        idle <= 0;
        zero_1 <= '0';
        valid_2 <= '0';
        zero_2 <= '0';
        speed_valid <= '0';
        speed_zero <= '0';
        speed_period <= slowest_c;
      end if;
    end if;

  end process p_measure;

end architecture rtl;
