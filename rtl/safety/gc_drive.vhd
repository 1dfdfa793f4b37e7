-- SPDX-License-Identifier: MIT
--
-- Current commands of all axes: the results of the core with limited magnitude and limited slew.
--
--   target = in_current clipped to +- cfg_limit
--   out_current := out_current + (target - out_current clipped to +- cfg_slew)      once per result
--   out_reached  = the command is in_current, neither limited nor ramping, and no clipped force is behind it
--   out_deviates = abs(in_current - out_current) > cfg_bound, exactly
--
-- Formats: 32 bits, uA -> 32 bits, uA. Latency: 6 clocks from in_valid to out_valid and out_current, 8 to out_deviates.
-- A result is taken every sixth clock at most; one that comes sooner is dropped.
-- run = '0': the command is zero one clock later, without a ramp. When run rises, the command ramps from zero.
-- cfg_* is sampled one clock before a result is taken. A limit that is lowered is reached by the slew, too.
-- Overflow: cannot happen. The command never leaves the interval from its last value to the target, and the target's
-- magnitude is below 2**31; -2**31 is clipped.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_drive is
  port (
    clk          : in    std_ulogic;
    -- Synchronous, active high; commands to zero.
    rst          : in    std_ulogic;
    -- '0': commands to zero.
    run          : in    std_ulogic;
    in_valid     : in    std_ulogic;
    -- Currents asked for, uA, axis 1 lowest.
    in_current   : in    signed(axes_c * current_bits_c - 1 downto 0);
    -- The current is not what the robot takes to be held: its force is saturated, or comes from a clamped count.
    in_clipped   : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Largest magnitude, uA, axis 1 lowest.
    cfg_limit    : in    unsigned(axes_c * (current_bits_c - 1) - 1 downto 0);
    -- Largest change per result, uA, axis 1 lowest; 0 keeps the command where it is.
    cfg_slew     : in    unsigned(axes_c * (current_bits_c - 1) - 1 downto 0);
    -- Largest distance of a command from the current asked for that is no deviation, uA, axis 1 lowest.
    cfg_bound    : in    unsigned(axes_c * (current_bits_c - 1) - 1 downto 0);
    -- One clock per result taken.
    out_valid    : out   std_ulogic := '0';
    -- Commands, uA, axis 1 lowest; hold until the next result.
    out_current  : out   signed(axes_c * current_bits_c - 1 downto 0) := (others => '0');
    -- The magnitude of the last result was clipped.
    out_limited  : out   std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    -- The motor carries the load: the command is the whole current of the last result; '0' from run = '0' to the first.
    out_reached  : out   std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    -- The motor is far from carrying it; '0' from run = '0' to the first result.
    out_deviates : out   std_ulogic_vector(axes_c - 1 downto 0) := (others => '0')
  );
end entity gc_drive;

architecture rtl of gc_drive is

  constant bits_c : positive := current_bits_c;

  -- Bit k: a result is in stage k.
  signal valid   : std_ulogic_vector(1 to 5) := (others => '0');
  signal valid_7 : std_ulogic := '0';
  signal taken   : std_ulogic;
  signal resting : std_ulogic;

begin

  taken <= in_valid when unsigned(valid) = 0 else '0';

  -- Limits stay as they are while a result uses them.
  resting <= '1' when taken = '0' and unsigned(valid(1 to 4)) = 0 else '0';

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid <= taken & valid(1 to 4);
      out_valid <= valid(5);
      valid_7 <= out_valid;
      if run = '0' or rst = '1' then
        valid <= (others => '0');
        out_valid <= '0';
        valid_7 <= '0';
      end if;
    end if;

  end process p_valid;

  -- The lower of two limits is the negative of the upper one, of which sums tell as much: no register holds it.

  g_axis : for i in 0 to axes_c - 1 generate

    subtype magnitude_c is natural range (i + 1) * (bits_c - 1) - 1 downto i * (bits_c - 1);

    signal ceiling   : signed(bits_c - 1 downto 0) := (others => '0');
    signal rise      : signed(bits_c - 1 downto 0) := (others => '0');
    signal above     : signed(bits_c - 1 downto 0) := (others => '0');
    signal asked_1   : signed(bits_c - 1 downto 0) := (others => '0');
    signal clipped_1 : std_ulogic := '0';
    signal above_1   : std_ulogic := '0';
    signal below_1   : std_ulogic := '0';
    signal target_2  : signed(bits_c - 1 downto 0) := (others => '0');
    signal gap_3     : signed(bits_c downto 0) := (others => '0');
    signal above_4   : std_ulogic := '0';
    signal below_4   : std_ulogic := '0';
    signal step_5    : signed(bits_c - 1 downto 0) := (others => '0');
    signal command   : signed(bits_c - 1 downto 0) := (others => '0');
    signal miss_7    : signed(bits_c downto 0) := (others => '0');
  begin

    p_limits : process (clk) is
    begin

      if rising_edge(clk) then
        if resting = '1' then
          ceiling <= signed('0' & cfg_limit(magnitude_c));
          rise <= signed('0' & cfg_slew(magnitude_c));
        end if;
        above <= signed('0' & cfg_bound(magnitude_c));
      end if;

    end process p_limits;

    p_drive : process (clk) is

      variable current_v : signed(bits_c - 1 downto 0);

    begin

      if rising_edge(clk) then
        -- stage 1: compare with the limits; what follows holds until stage 6
        current_v := in_current((i + 1) * bits_c - 1 downto i * bits_c);
        if taken = '1' then
          asked_1 <= current_v;
          clipped_1 <= in_clipped(i);
          above_1 <= '0';
          if current_v > ceiling then
            above_1 <= '1';
          end if;
          below_1 <= '0';
          if resize(current_v, bits_c + 1) + ceiling < 0 then
            below_1 <= '1';
          end if;
        end if;

        -- stage 2: clip
        target_2 <= asked_1;
        if above_1 = '1' then
          target_2 <= ceiling;
        elsif below_1 = '1' then
          target_2 <= -ceiling;
        end if;

        -- stage 3: distance, one bit wider than its terms
        gap_3 <= resize(target_2, bits_c + 1) - command;

        -- stage 4: compare with the slew
        above_4 <= '0';
        if gap_3 > rise then
          above_4 <= '1';
        end if;
        below_4 <= '0';
        if resize(gap_3, bits_c + 2) + rise < 0 then
          below_4 <= '1';
        end if;

        -- stage 5: clip
        step_5 <= gap_3(bits_c - 1 downto 0);
        if above_4 = '1' then
          step_5 <= rise;
        elsif below_4 = '1' then
          step_5 <= -rise;
        end if;

        -- stage 6: the command
        if valid(5) = '1' then
          command <= command + step_5;
          out_limited(i) <= above_1 or below_1;
          out_reached(i) <= not (above_1 or below_1 or above_4 or below_4 or clipped_1);
        end if;

        -- stage 7: what the command misses, before the next result is asked for; one bit wider than its terms
        miss_7 <= resize(asked_1, bits_c + 1) - command;

        -- stage 8: compare with the bound
        if valid_7 = '1' then
          out_deviates(i) <= '0';
          if miss_7 > above or resize(miss_7, bits_c + 2) + above < 0 then
            out_deviates(i) <= '1';
          end if;
        end if;

        if run = '0' or rst = '1' then
          command <= (others => '0');
          out_limited(i) <= '0';
          out_reached(i) <= '0';
          out_deviates(i) <= '0';
        end if;
      end if;

    end process p_drive;

    out_current((i + 1) * bits_c - 1 downto i * bits_c) <= command;
  end generate g_axis;

end architecture rtl;
