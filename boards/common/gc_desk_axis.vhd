-- SPDX-License-Identifier: MIT
--
-- An axis for a board on a desk: a motor of the first order with a brake, and the incremental encoder on it.
--
-- From reset on a hand moves it to and fro over its index mark, which is a count wide, until the brake is released for the
-- first time. The current of that clock is taken to carry the load: with the brake released the axis speeds up by the
-- current beyond that, less its speed by 2**-damping_g, once in step_clocks_g clocks. With the brake engaged it stands.
-- Position and speed have a fraction of 16 bits of a count; the speed ends at a count in 16 steps.
-- Latency: one step from the current to the speed, another to the pins.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_desk_axis is
  generic (
    -- Counts from the mark to where the hand turns, on either side.
    travel_g      : positive := 100;
    -- Clocks per step of the motion.
    step_clocks_g : positive := 64;
    -- Of the speed, a step: 2**-damping_g.
    damping_g     : positive := 6
  );
  port (
    clk        : in    std_ulogic;
    rst        : in    std_ulogic;
    -- uA, held.
    in_current : in    signed(31 downto 0);
    -- '1': the brake lets the axis move.
    released   : in    std_ulogic;
    pin_a      : out   std_ulogic := '0';
    pin_b      : out   std_ulogic := '0';
    pin_z      : out   std_ulogic := '0'
  );
end entity gc_desk_axis;

architecture rtl of gc_desk_axis is

  constant fraction_c : positive := 16;
  -- Where both channels are high, the phase in which gc_quad_decoder looks for it.
  constant mark_c     : integer  := 2;
  -- A count in 16 steps: 16 * step_clocks_g clocks from edge to edge.
  constant fastest_c  : signed(fraction_c downto 0) := to_signed(2 ** (fraction_c - 4), fraction_c + 1);
  constant hand_c     : signed(fraction_c downto 0) := to_signed(2 ** (fraction_c - 5), fraction_c + 1);

  signal by_hand  : std_ulogic := '1';
  signal up       : std_ulogic := '1';
  signal clocks   : natural range 0 to step_clocks_g - 1 := 0;
  signal position : signed(31 + fraction_c downto 0) := (others => '0');
  signal speed    : signed(fraction_c downto 0) := (others => '0');

  -- What the current was when the brake was released, uA.
  signal load : signed(31 downto 0) := (others => '0');

  -- The next speed: 2**-16 counts a step for each 256 uA beyond the load, less the damping, within the fastest.

  function driven (
    was     : signed(fraction_c downto 0);
    current : signed(31 downto 0);
    carries : signed(31 downto 0)
  ) return signed is

    variable push_v : signed(32 downto 0);
    variable next_v : signed(33 downto 0);

  begin

    push_v := resize(current, 33) - resize(carries, 33);
    next_v := resize(shift_right(push_v, 8), 34) + was - shift_right(was, damping_g);

    if next_v > fastest_c then
      return fastest_c;
    elsif next_v < -fastest_c then
      return -fastest_c;
    end if;

    return resize(next_v, fraction_c + 1);

  end function driven;

begin

  p_motion : process (clk) is
  begin

    if rising_edge(clk) then
      if released = '1' then
        by_hand <= '0';
      end if;
      if by_hand = '1' then
        load <= in_current;
      end if;

      if clocks /= step_clocks_g - 1 then
        clocks <= clocks + 1;
      else
        clocks <= 0;
        position <= position + speed;

        if by_hand = '1' then
          if position(position'high downto fraction_c) >= travel_g then
            up <= '0';
          elsif position(position'high downto fraction_c) <= -travel_g then
            up <= '1';
          end if;
          speed <= hand_c;
          if up = '0' then
            speed <= -hand_c;
          end if;
        elsif released = '1' then
          -- From the hand's last speed on.
          speed <= driven(speed, in_current, load);
        else
          speed <= (others => '0');
        end if;
      end if;

      if rst = '1' then
        by_hand <= '1';
        up <= '1';
        clocks <= 0;
        position <= (others => '0');
        speed <= (others => '0');
      end if;
    end if;

  end process p_motion;

  p_encoder : process (clk) is

    variable count_v : signed(31 downto 0);

  begin

    if rising_edge(clk) then
      count_v := position(position'high downto fraction_c);
      pin_a <= count_v(1) xor count_v(0);
      pin_b <= count_v(1);
      pin_z <= '0';
      if count_v = mark_c then
        pin_z <= '1';
      end if;
    end if;

  end process p_encoder;

end architecture rtl;
