-- SPDX-License-Identifier: MIT
--
-- A signed value as pulses on two pins: of a period of clocks_g clocks as many are high as
--
--   on = floor(abs(value) factor / 2**f), at most clocks_g,     factor / 2**f = clocks_g / full_scale_g
--
-- with 17 bits of factor, so that on is exact to 2**-17 of itself, and a clock.
-- two_pins_g = false: pin_a is high for on clocks, pin_b is the sign, '1' negative.
-- two_pins_g = true: pin_a is high for positive values, pin_b for negative ones, never both.
-- When the sign changes, neither is high for dead_g clocks before and dead_g clocks after it does. A value of zero, or
-- one too small for a clock, keeps the sign.
--
-- Format: 32 bits -> pins. Latency: 4 clocks to the value of the next period; a value is taken as a period begins.
-- enable = '0': neither is high one clock later; when it rises, the period goes on. Overflow: cannot happen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;
  use ieee.math_real.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_pwm is
  generic (
    -- Clocks of a period, 2 to 65535.
    clocks_g     : positive := 2000;
    -- Value at which all clocks are high, 2 to 2**31 - 1.
    full_scale_g : positive := 10_000_000;
    -- Clocks before and after a change of the sign in which neither pin is high.
    dead_g       : natural := 20;
    -- A pin for each sign, or one for the magnitude and one for the sign.
    two_pins_g   : boolean := false
  );
  port (
    clk      : in    std_ulogic;
    -- Synchronous, active high: neither pin is high.
    rst      : in    std_ulogic;
    enable   : in    std_ulogic;
    in_value : in    signed(31 downto 0);
    pin_a    : out   std_ulogic;
    pin_b    : out   std_ulogic
  );
end entity gc_pwm;

architecture rtl of gc_pwm is

  -- In 2**16 .. 2**17.
  constant fraction_c : integer := 16 - integer(floor(log2(real(clocks_g) / real(full_scale_g))));
  constant factor_c   : natural := integer(round(real(clocks_g) / real(full_scale_g) * 2.0 ** fraction_c));

  signal magnitude : signed(32 downto 0);
  signal product   : signed(50 downto 0);
  -- Signs that wait for their products.
  signal sign      : std_ulogic_vector(1 to 3) := (others => '0');
  signal on_3      : natural range 0 to clocks_g := 0;

  signal position : natural range 0 to clocks_g - 1 := 0;
  -- What this period is for.
  signal high     : natural range 0 to clocks_g := 0;
  signal wanted   : std_ulogic := '0';
  -- What the pins say.
  signal wave     : std_ulogic := '0';
  signal negative : std_ulogic := '0';
  -- Clocks that wave has been low, and that it has to stay so; both stop at dead_g and 0.
  signal quiet    : natural range 0 to dead_g := 0;
  signal rest     : natural range 0 to dead_g := 0;

begin

  assert clocks_g >= 2 and clocks_g < 65536
    report "gc_pwm: need clocks_g in 2 to 65535, got " & integer'image(clocks_g)
    severity failure;

  magnitude <= -resize(in_value, 33) when in_value < 0 else resize(in_value, 33);

  -- stages 1 and 2
  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => 33,
      b_bits_g => 18
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => '0',
      in_a        => magnitude,
      in_b        => to_signed(factor_c, 18),
      out_valid   => open,
      out_product => product
    );

  p_scale : process (clk) is

    variable on_v : signed(50 downto 0);

  begin

    if rising_edge(clk) then
      sign <= in_value(31) & sign(1 to 2);
      -- stage 3
      on_v := truncate(product, fraction_c, 51);
      on_3 <= clocks_g;
      if on_v < clocks_g then
        on_3 <= to_integer(on_v(16 downto 0));
      end if;
    end if;

  end process p_scale;

  p_pulses : process (clk) is
  begin

    if rising_edge(clk) then
      if position /= clocks_g - 1 then
        position <= position + 1;
      else
        position <= 0;
        high <= on_3;
        if on_3 /= 0 then
          wanted <= sign(3);
        end if;
      end if;

      wave <= '0';
      if rest /= 0 then
        rest <= rest - 1;
      elsif wanted /= negative then
        if wave = '0' and quiet = dead_g then
          negative <= wanted;
          rest <= dead_g;
        end if;
      elsif position < high and enable = '1' then
        wave <= '1';
      end if;

      if wave = '1' then
        quiet <= 0;
      elsif quiet /= dead_g then
        quiet <= quiet + 1;
      end if;

      if rst = '1' then
        position <= 0;
        high <= 0;
        wanted <= '0';
        wave <= '0';
        negative <= '0';
        quiet <= 0;
        rest <= dead_g;
      end if;
    end if;

  end process p_pulses;

  pin_a <= wave when not two_pins_g else wave and not negative;
  pin_b <= negative when not two_pins_g else wave and negative;

end architecture rtl;
