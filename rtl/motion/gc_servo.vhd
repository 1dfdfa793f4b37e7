-- SPDX-License-Identifier: MIT
--
-- A PID per axis that adds to the feed-forward what holds the axis at its setpoint.
--
--   e = setpoint - count                       lag = place - slow,   slow := slow + lag / 2**filter     (counts)
--   correction = limited(P e + integral - D lag)                     integral := limited(integral + I e)
--   out_current = saturated(feed_current + correction)
--
-- place is the count, or with cfg_speed_feed what it is ahead of the setpoint, -e. slow is that behind a low-pass of
-- 2**filter ticks, so lag / 2**filter is a filtered speed in counts per tick: D is the derivative gain, divided by
-- 2**filter ticks, on the measured speed, or with cfg_speed_feed on what that is ahead of the setpoint's: a motion that
-- is wanted is not braked. limited: to +- cfg_limit of the axis.
-- Anti-windup: an integral that is limited, or would drive a correction further that is beyond the limit, stays.
-- Transparent with all gains zero; where I is zero the integral is.
-- run = '0', that is braked or any fault: correction, integral and lag are zero one clock later, and start from there.
-- The lag also starts from zero in the tick that finds another cfg_speed_feed.
-- gc_drive stands behind: what a change of gains, limits or constants moves the sum by, it ramps by its slew.
--
-- Formats: 32 bits, counts; feed, limit, correction 32 bits, uA. Gains 32 bits: P uA per count with 12 bits behind the
-- point, I uA per count and tick with 20, D uA per count of lag with 8. e is clipped to 24 bits, lag to 24 bits with 4
-- behind the point; out_astray compares before that. Bits are dropped downwards.
-- Latency: 9 axes_g + 1 clocks from in_valid to the last correction, 1 clock from feed_valid to out_valid. The
-- correction of the tick before is added until the new one is there. A tick that comes while one is worked on is
-- dropped; cfg_* is read meanwhile. Overflow: cannot happen; the bounds stand at the sums.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;
  use work.gc_servo_pkg.all;

entity gc_servo is
  generic (
    -- Axes, 1 to 8.
    axes_g : positive := 3
  );
  port (
    clk              : in    std_ulogic;
    -- Synchronous, active high; as run = '0'.
    rst              : in    std_ulogic;
    -- '0': nothing is corrected, nothing remembered.
    run              : in    std_ulogic;
    -- One clock per tick: counts and setpoints, counts, axis 1 lowest.
    in_valid         : in    std_ulogic;
    in_count         : in    signed(axes_g * 32 - 1 downto 0);
    in_setpoint      : in    signed(axes_g * 32 - 1 downto 0);
    -- Gains, axis 1 lowest.
    cfg_proportional : in    unsigned(axes_g * gain_bits_c - 1 downto 0);
    cfg_integral     : in    unsigned(axes_g * gain_bits_c - 1 downto 0);
    cfg_derivative   : in    unsigned(axes_g * gain_bits_c - 1 downto 0);
    -- Ticks of the low-pass, as a power of two, of every axis.
    cfg_filter       : in    unsigned(filter_bits_c - 1 downto 0);
    -- The setpoints' speed is fed forward, on every axis.
    cfg_speed_feed   : in    std_ulogic;
    -- Largest correction, uA, axis 1 lowest.
    cfg_limit        : in    unsigned(axes_g * 31 - 1 downto 0);
    -- Largest position error that is no fault, counts, axis 1 lowest.
    cfg_astray       : in    unsigned(axes_g * 32 - 1 downto 0);
    -- Feed-forward, uA, axis 1 lowest.
    feed_valid       : in    std_ulogic;
    feed_current     : in    signed(axes_g * 32 - 1 downto 0);
    -- Feed-forward with its correction, uA, axis 1 lowest; holds until the next.
    out_valid        : out   std_ulogic := '0';
    out_current      : out   signed(axes_g * 32 - 1 downto 0) := (others => '0');
    -- The position error of the last tick is larger than cfg_astray: a cause of gc_safety.
    out_astray       : out   std_ulogic_vector(axes_g - 1 downto 0) := (others => '0');
    -- Corrections, uA, axis 1 lowest.
    sts_correction   : out   signed(axes_g * 32 - 1 downto 0)
  );
end entity gc_servo;

architecture rtl of gc_servo is

  -- Largest magnitudes. A product: 2**32 2**23 = 2**55, in product_c bits with its sign. The integral: 2**31 2**20.
  constant product_c  : positive := gain_bits_c + 1 + distance_bits_c;
  constant integral_c : positive := 32 + integral_fraction_c;
  constant slow_c     : positive := 33 + slow_fraction_c;
  constant drop_c     : natural := slow_fraction_c - lag_fraction_c;
  constant gap_c      : natural := integral_fraction_c - proportional_fraction_c;

  type words_t is array (0 to axes_g - 1) of signed(31 downto 0);

  type gains_t is array (0 to axes_g - 1) of signed(gain_bits_c downto 0);

  type integrals_t is array (0 to axes_g - 1) of signed(integral_c - 1 downto 0);

  type slows_t is array (0 to axes_g - 1) of signed(slow_c - 1 downto 0);

  signal proportional : gains_t;
  signal integral     : gains_t;
  signal derivative   : gains_t;
  signal ceiling      : words_t;
  signal astray       : gains_t;

  -- The axis that is worked on, and bit k: it is in step k.
  signal axis  : natural range 0 to axes_g - 1 := 0;
  signal step  : std_ulogic_vector(1 to servo_steps_c) := (others => '0');
  -- A tick is taken.
  signal takes : std_ulogic;

  -- What came with the tick.
  signal count    : words_t;
  signal setpoint : words_t;
  signal feeds    : std_ulogic := '0';

  signal error_1  : signed(32 downto 0);
  signal place_1  : signed(32 downto 0);
  signal error_2  : signed(distance_bits_c - 1 downto 0);
  signal lag_2    : signed(slow_c downto 0);
  signal lag_3    : signed(distance_bits_c - 1 downto 0);
  signal gain     : signed(gain_bits_c downto 0);
  signal distance : signed(distance_bits_c - 1 downto 0);
  signal product  : signed(product_c - 1 downto 0);
  signal p_5      : signed(product_c - 1 downto 0);
  signal sum_6    : signed(product_c downto 0);
  signal kept_7   : signed(integral_c - 1 downto 0);
  signal swing_7  : signed(product_c downto 0);
  signal total_8  : signed(product_c + 1 downto 0);

  -- Axes that a tick has found since run rose or feeds changed; their integral (uA), low-passed place (counts) and
  -- correction (uA).
  signal known      : std_ulogic_vector(axes_g - 1 downto 0) := (others => '0');
  signal summed     : integrals_t := (others => (others => '0'));
  signal slow       : slows_t;
  signal correction : words_t := (others => (others => '0'));

begin

  assert axes_g <= most_axes_c
    report "gc_servo: need axes_g <= 8, got " & integer'image(axes_g)
    severity failure;

  g_axis : for i in 0 to axes_g - 1 generate
    proportional(i) <= signed('0' & cfg_proportional((i + 1) * gain_bits_c - 1 downto i * gain_bits_c));
    integral(i) <= signed('0' & cfg_integral((i + 1) * gain_bits_c - 1 downto i * gain_bits_c));
    derivative(i) <= signed('0' & cfg_derivative((i + 1) * gain_bits_c - 1 downto i * gain_bits_c));
    ceiling(i) <= signed('0' & cfg_limit((i + 1) * 31 - 1 downto i * 31));
    astray(i) <= signed('0' & cfg_astray((i + 1) * 32 - 1 downto i * 32));
    sts_correction((i + 1) * 32 - 1 downto i * 32) <= correction(i);
  end generate g_axis;

  takes <= '1' when in_valid = '1' and unsigned(step) = 0 else '0';

  -- One axis after the other, one step a clock: one multiplier serves three gains of all axes.
  p_steps : process (clk) is
  begin

    if rising_edge(clk) then
      step <= '0' & step(1 to servo_steps_c - 1);
      if step(servo_steps_c) = '1' and axis /= axes_g - 1 then
        axis <= axis + 1;
        step(1) <= '1';
      end if;
      if takes = '1' then
        axis <= 0;
        step(1) <= '1';
        feeds <= cfg_speed_feed;

        for i in 0 to axes_g - 1 loop

          count(i) <= in_count((i + 1) * 32 - 1 downto i * 32);
          setpoint(i) <= in_setpoint((i + 1) * 32 - 1 downto i * 32);

        end loop;

      end if;
      if rst = '1' then
        step <= (others => '0');
      end if;
    end if;

  end process p_steps;

  p_operands : process (all) is
  begin

    gain <= proportional(axis);
    distance <= error_2;

    if step(4) = '1' then
      gain <= integral(axis);
    elsif step(5) = '1' then
      gain <= derivative(axis);
      distance <= lag_3;
    end if;

  end process p_operands;

  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => gain'length,
      b_bits_g => distance'length
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => '0',
      in_a        => gain,
      in_b        => distance,
      out_valid   => open,
      out_product => product
    );

  p_servo : process (clk) is

    variable slow_v  : signed(slow_c downto 0);
    variable most_v  : signed(integral_c - 1 downto 0);
    variable whole_v : signed(total_8'length - proportional_fraction_c - 1 downto 0);

  begin

    if rising_edge(clk) then
      -- step 1: distances, one bit wider than their terms
      error_1 <= resize(setpoint(axis), 33) - count(axis);
      place_1 <= resize(count(axis), 33);
      if feeds = '1' then
        place_1 <= resize(count(axis), 33) - setpoint(axis);
      end if;

      -- step 2: so is the lag; the error is clipped
      lag_2 <= shift_left(resize(place_1, slow_c + 1), slow_fraction_c) - slow(axis);
      if step(2) = '1' then
        error_2 <= saturate(error_1, distance_bits_c);
        out_astray(axis) <= '0';
        if error_1 > astray(axis) or error_1 < -astray(axis) then
          out_astray(axis) <= '1';
        end if;
      end if;

      -- step 3: so is the lag. slow moves towards the place and never beyond it.
      slow_v := slow(axis) + shift_right(lag_2, to_integer(cfg_filter));
      if step(3) = '1' then
        lag_3 <= saturate(truncate(lag_2, drop_c, lag_2'length - drop_c), distance_bits_c);
        slow(axis) <= slow_v(slow_c - 1 downto 0);
        known(axis) <= '1';
        if known(axis) = '0' then
          lag_3 <= (others => '0');
          slow(axis) <= shift_left(resize(place_1, slow_c), slow_fraction_c);
        end if;
      end if;

      -- steps 3 to 7: the products of P, I and D come out in the clocks of steps 5, 6 and 7
      if step(5) = '1' then
        p_5 <= product;
      end if;

      -- step 6: integral + I e < 2**51 + 2**55
      if step(6) = '1' then
        sum_6 <= resize(summed(axis), product_c + 1) + product;
      end if;

      -- step 7: the integral clipped; P e - D lag < 2**55 + 2**55
      most_v := shift_left(resize(ceiling(axis), integral_c), integral_fraction_c);
      kept_7 <= sum_6(integral_c - 1 downto 0);
      if sum_6 > most_v then
        kept_7 <= most_v;
      elsif sum_6 < -most_v then
        kept_7 <= -most_v;
      end if;
      if integral(axis) = 0 then
        kept_7 <= (others => '0');
      end if;
      swing_7 <= resize(p_5, product_c + 1) - product;

      -- step 8: their sum < 2**56 + 2**43
      total_8 <= resize(swing_7, product_c + 2) + truncate(kept_7, gap_c, integral_c - gap_c);

      -- step 9: the correction
      whole_v := truncate(total_8, proportional_fraction_c, whole_v'length);
      if step(9) = '1' then
        correction(axis) <= whole_v(31 downto 0);
        summed(axis) <= kept_7;
        if whole_v > ceiling(axis) then
          correction(axis) <= ceiling(axis);
          if error_2 > 0 and integral(axis) /= 0 then
            summed(axis) <= summed(axis);
          end if;
        elsif whole_v < -ceiling(axis) then
          correction(axis) <= -ceiling(axis);
          if error_2 < 0 and integral(axis) /= 0 then
            summed(axis) <= summed(axis);
          end if;
        end if;
      end if;

      if takes = '1' and cfg_speed_feed /= feeds then
        known <= (others => '0');
      end if;
      if run = '0' or rst = '1' then
        known <= (others => '0');
        summed <= (others => (others => '0'));
        correction <= (others => (others => '0'));
        out_astray <= (others => '0');
      end if;
    end if;

  end process p_servo;

  p_add : process (clk) is

    variable sum_v : signed(32 downto 0);

  begin

    if rising_edge(clk) then
      out_valid <= feed_valid;
      if feed_valid = '1' then

        for i in 0 to axes_g - 1 loop

          sum_v := resize(feed_current((i + 1) * 32 - 1 downto i * 32), 33) + correction(i);
          out_current((i + 1) * 32 - 1 downto i * 32) <= saturate(sum_v, 32);

        end loop;

      end if;
      if rst = '1' then
        out_valid <= '0';
        out_current <= (others => '0');
      end if;
    end if;

  end process p_add;

end architecture rtl;
