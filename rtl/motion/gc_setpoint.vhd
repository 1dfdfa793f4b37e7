-- SPDX-License-Identifier: MIT
--
-- Moves the setpoints of all axes from where they are to a target, together, along minimum jerk.
--
--   setpoint = start + (target - start) s(u),   s = u**3 (10 - 15 u + 6 u**2),   u = 0 .. 1 in equal steps
--
-- One s for all axes: they start and arrive in the same tick, on a straight line in joint space.
-- A move takes move_ticks, at least 2, or longer: the step of u is shortened by sixteenths until each axis keeps
--   cfg_speed        >= 15/8 (target - start) / ticks
--   cfg_acceleration >= 47/8 (target - start) / ticks**2         (the peak is 10/sqrt(3) = 0.983 47/8)
-- with the right side rounded up. A move that cannot keep them, as a limit is zero, is refused: nothing moves.
-- A move is taken at rest only (move_ready), so setpoint and its speed never jump.
-- run = '0': no move, the setpoint is the count of the clock before. So nothing pulls when run rises.
--
-- Formats: counts 32 bits; speed 2**-16 counts per tick, acceleration 2**-24 counts per tick**2, 32 bits.
-- The target is met exactly; between, s is rounded down to 32 bits behind the point, the setpoint to a count.
-- Latency: planning takes 33 clocks and 6 axes_g for each step of u that is tried, some 300 at most; the first tick
-- after it is the first of the move. From in_valid to the last setpoint 10 + 3 axes_g clocks; a tick that comes sooner
-- is not taken. Overflow: cannot happen, the bounds stand at the sums.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;
  use work.gc_servo_pkg.all;

entity gc_setpoint is
  generic (
    -- Axes, 1 to 8.
    axes_g : positive := 3
  );
  port (
    clk              : in    std_ulogic;
    -- Synchronous, active high; as run = '0'.
    rst              : in    std_ulogic;
    -- '0': the setpoint follows the count.
    run              : in    std_ulogic;
    -- Counts, axis 1 lowest.
    in_count         : in    signed(axes_g * 32 - 1 downto 0);
    -- One clock per tick: the setpoint goes on.
    in_valid         : in    std_ulogic;
    -- A move begins in a clock with both: targets, counts, axis 1 lowest, and how long it takes, ticks.
    move_valid       : in    std_ulogic;
    move_ready       : out   std_ulogic;
    move_target      : in    signed(axes_g * 32 - 1 downto 0);
    move_ticks       : in    unsigned(31 downto 0);
    -- Limits, 2**-16 counts per tick and 2**-24 counts per tick**2, axis 1 lowest; they hold while a move is planned.
    cfg_speed        : in    unsigned(axes_g * 32 - 1 downto 0);
    cfg_acceleration : in    unsigned(axes_g * 32 - 1 downto 0);
    -- Setpoints, counts, axis 1 lowest.
    out_setpoint     : out   signed(axes_g * 32 - 1 downto 0);
    -- The last move could not keep the limits, and was not made.
    sts_refused      : out   std_ulogic := '0';
    -- The step of u of the last move, 2**-32: it takes 2**32 / sts_rate ticks, rounded up.
    sts_rate         : out   unsigned(31 downto 0)
  );
end entity gc_setpoint;

architecture rtl of gc_setpoint is

  -- Planning: 2**32 / ticks, then for each axis its speed and its acceleration. Moving: awaiting a tick, then u**2,
  -- u**3, s and, for each axis, its setpoint. From speed on a state is a product and lasts three clocks.

  type state_t is (at_rest, awaiting, divide, speed, acceleration, square, cube, blend, place);

  type words_t is array (0 to axes_g - 1) of signed(31 downto 0);

  type spans_t is array (0 to axes_g - 1) of signed(32 downto 0);

  type limits_t is array (0 to axes_g - 1) of unsigned(31 downto 0);

  -- Bits behind the point of 10 - 15 u + 6 u**2, which is 1 to 10.
  constant factor_fraction_c : positive := 28;

  -- Half a count, of start + (target - start) s.
  constant half_c : signed(65 downto 0) := (31 => '1', others => '0');

  signal speed_limit        : limits_t;
  signal acceleration_limit : limits_t;

  signal state       : state_t := at_rest;
  signal is_product  : std_ulogic;
  -- A product is there; a move is taken; a tick moves on.
  signal told        : std_ulogic;
  signal takes       : std_ulogic;
  signal steps       : std_ulogic;
  signal turn        : natural range 0 to 2 := 0;
  signal axis        : natural range 0 to axes_g - 1 := 0;
  signal setpoint    : words_t := (others => (others => '0'));
  signal start       : words_t;
  signal span        : spans_t;
  -- What is left of 2**32 by the ticks asked for, and bits of the quotient that are still to come.
  signal ticks       : unsigned(31 downto 0);
  signal remainder   : unsigned(31 downto 0);
  signal bits_left   : natural range 0 to 31 := 0;
  signal rate        : unsigned(31 downto 0) := (others => '0');
  -- u; then u**2, u**3 or s; 10 - 15 u + 6 u**2.
  signal phase       : unsigned(31 downto 0);
  signal next_phase  : unsigned(32 downto 0);
  signal power       : unsigned(31 downto 0);
  signal factor      : unsigned(31 downto 0);
  -- (target - start) / ticks, 2**-16 counts per tick.
  signal velocity    : unsigned(31 downto 0);
  -- What a product means while planning: that, and its change, 2**-24 counts per tick**2, rounded up.
  signal mean_speed  : unsigned(51 downto 0);
  signal mean_change : unsigned(45 downto 0);
  signal too_fast    : std_ulogic;
  signal a           : signed(32 downto 0);
  signal b           : signed(32 downto 0);
  signal product     : signed(65 downto 0);

  -- Without its sign; |value| < 2**32.

  function magnitude (
    value : signed(32 downto 0)
  ) return signed is
  begin

    if value < 0 then
      return -value;
    end if;

    return value;

  end function magnitude;

begin

  assert axes_g <= most_axes_c
    report "gc_setpoint: need axes_g <= 8, got " & integer'image(axes_g)
    severity failure;

  g_axis : for i in 0 to axes_g - 1 generate
    speed_limit(i) <= cfg_speed((i + 1) * 32 - 1 downto i * 32);
    acceleration_limit(i) <= cfg_acceleration((i + 1) * 32 - 1 downto i * 32);
    out_setpoint((i + 1) * 32 - 1 downto i * 32) <= setpoint(i);
  end generate g_axis;

  is_product <= '0' when state = at_rest or state = awaiting or state = divide else '1';
  move_ready <= run when state = at_rest else '0';
  sts_rate <= rate;

  p_operands : process (all) is
  begin

    a <= signed('0' & power);
    b <= signed('0' & phase);

    if state = speed then
      a <= magnitude(span(axis));
      b <= signed('0' & rate);
    elsif state = acceleration then
      a <= signed('0' & velocity);
      b <= signed('0' & rate);
    elsif state = square then
      a <= signed('0' & phase);
    elsif state = blend then
      b <= signed('0' & factor);
    elsif state = place then
      a <= span(axis);
      b <= signed('0' & power);
    end if;

  end process p_operands;

  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => a'length,
      b_bits_g => b'length
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => '0',
      in_a        => a,
      in_b        => b,
      out_valid   => open,
      out_product => product
    );

  told <= '1' when is_product = '1' and turn = 2 else '0';
  takes <= move_valid when state = at_rest else '0';
  steps <= in_valid when state = awaiting else '0';
  next_phase <= resize(phase, 33) + rate;

  -- 2 ticks at least: the product is below 2**63. So the mean speed is at most 2**47, 16 times that below 2**52, and
  -- its change at most 2**39, 48 times that below 2**46.
  mean_speed <= resize(unsigned(truncate(product + (2 ** 16 - 1), 16, 50)), 52);
  mean_change <= resize(unsigned(truncate(product + (2 ** 24 - 1), 24, 42)), 46);

  p_limits : process (all) is
  begin

    too_fast <= '0';

    if state = speed then
      if shift_left(mean_speed, 4) - mean_speed > shift_left(resize(speed_limit(axis), 52), 3) then
        too_fast <= '1';
      end if;
    elsif state = acceleration then
      if shift_left(mean_change, 5) + shift_left(mean_change, 4) - mean_change
         > shift_left(resize(acceleration_limit(axis), 46), 3) then
        too_fast <= '1';
      end if;
    end if;

  end process p_limits;

  p_state : process (clk) is
  begin

    if rising_edge(clk) then
      turn <= 0;
      if is_product = '1' and turn /= 2 then
        turn <= turn + 1;
      end if;

      if takes = '1' then
        state <= divide;
      elsif state = divide and bits_left = 0 then
        state <= speed;
      elsif steps = '1' then
        state <= square;
        if next_phase(32) = '1' then
          state <= at_rest;
        end if;
      elsif told = '1' and too_fast = '1' then
        axis <= 0;
        state <= speed;
        if rate <= 1 then
          state <= at_rest;
        end if;
      elsif told = '1' and state = speed then
        state <= acceleration;
      elsif told = '1' and state = square then
        state <= cube;
      elsif told = '1' and state = cube then
        state <= blend;
      elsif told = '1' and state = blend then
        state <= place;
      elsif told = '1' and axis /= axes_g - 1 then
        -- acceleration and place: the next axis, or all are done
        axis <= axis + 1;
        if state = acceleration then
          state <= speed;
        end if;
      elsif told = '1' then
        axis <= 0;
        state <= awaiting;
      end if;

      if run = '0' or rst = '1' then
        state <= at_rest;
        turn <= 0;
        axis <= 0;
      end if;
    end if;

  end process p_state;

  p_rate : process (clk) is

    variable twice_v : unsigned(32 downto 0);

  begin

    if rising_edge(clk) then
      if takes = '1' then
        ticks <= move_ticks;
        if move_ticks < 2 then
          ticks <= to_unsigned(2, 32);
        end if;
        remainder <= to_unsigned(1, 32);
        bits_left <= 31;
      end if;

      -- 2**32 / ticks, a bit a clock: the remainder is below the divisor, twice it below 2**33
      if state = divide then
        twice_v := remainder & '0';
        remainder <= twice_v(31 downto 0);
        rate <= rate(30 downto 0) & '0';
        if twice_v >= ticks then
          twice_v := twice_v - ticks;
          remainder <= twice_v(31 downto 0);
          rate(0) <= '1';
        end if;
        if bits_left /= 0 then
          bits_left <= bits_left - 1;
        end if;
      end if;

      if told = '1' then
        velocity <= mean_speed(31 downto 0);
        -- a step of u that is too long is shortened, by 1 at least
        if too_fast = '1' then
          rate <= rate - shift_right(rate, 4);
          if rate < 16 then
            rate <= rate - 1;
          end if;
        end if;
      end if;

      if told = '1' and too_fast = '1' and rate <= 1 then
        sts_refused <= '1';
      end if;
      if takes = '1' or run = '0' or rst = '1' then
        sts_refused <= '0';
      end if;
    end if;

  end process p_rate;

  p_path : process (clk) is

    variable factor_v : unsigned(35 downto 0);
    variable place_v  : signed(33 downto 0);

  begin

    if rising_edge(clk) then
      if takes = '1' then
        phase <= (others => '0');
        start <= setpoint;

        for i in 0 to axes_g - 1 loop

          span(i) <= resize(move_target((i + 1) * 32 - 1 downto i * 32), 33) - setpoint(i);

        end loop;

      end if;

      if steps = '1' then
        phase <= next_phase(31 downto 0);
        -- u = 1: the target itself
        if next_phase(32) = '1' then

          for i in 0 to axes_g - 1 loop

            place_v := resize(start(i), 34) + span(i);
            setpoint(i) <= place_v(31 downto 0);

          end loop;

        end if;
      end if;

      -- What is rounded down all the way stays between 0 and the exact s, which is below 1. 10 - 15 u can be negative:
      -- what counts is its sum with 6 u**2, for which 36 bits are exact.
      if told = '1' and state /= place then
        power <= unsigned(product(63 downto 32));
        if state = blend then
          power <= unsigned(product(factor_fraction_c + 31 downto factor_fraction_c));
        end if;
      end if;
      if told = '1' and state = square then
        factor_v := resize(unsigned(product(63 downto 32)), 36);
        factor_v := shift_left(factor_v, 2) + shift_left(factor_v, 1);
        factor_v := factor_v + (to_unsigned(10, 4) & to_unsigned(0, 32));
        factor_v := factor_v + phase - shift_left(resize(phase, 36), 4);
        factor <= factor_v(35 downto 36 - factor'length);
      end if;

      -- start + (target - start) s lies between the two
      if told = '1' and state = place then
        place_v := resize(start(axis), 34) + truncate(product + half_c, 32, 34);
        setpoint(axis) <= place_v(31 downto 0);
      end if;

      if run = '0' or rst = '1' then

        for i in 0 to axes_g - 1 loop

          setpoint(i) <= in_count((i + 1) * 32 - 1 downto i * 32);

        end loop;

      end if;
    end if;

  end process p_path;

end architecture rtl;
