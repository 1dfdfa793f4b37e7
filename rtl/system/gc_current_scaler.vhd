-- SPDX-License-Identifier: MIT
--
-- i = f / K_t with the K_t of each axis: efforts to motor currents, by one multiplication and rounding.
--
-- Formats: 24 bits, mN or mNm -> 32 bits, uA. Latency: 4 clocks; where axes share a multiplier their number + 4, and
-- in_force is then read one by one, as of gc_scale. Overflow: a current that does not fit saturates and is flagged; of
-- an axis of more than 3.9 N/A or Nm/A every one fits.
-- Not part of the network's budget of operations.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_current_scaler is
  generic (
    -- Axes that share a multiplier, in turn; it divides their number.
    turns_g : positive := 1
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst           : in    std_ulogic;
    in_valid      : in    std_ulogic;
    -- Forces, mN, axis 1 lowest.
    in_force      : in    signed(axes_c * force_bits_c - 1 downto 0);
    out_valid     : out   std_ulogic;
    -- Motor currents, uA, axis 1 lowest.
    out_current   : out   signed(axes_c * current_bits_c - 1 downto 0);
    -- The current of this axis saturated; with out_valid.
    out_saturated : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Constants in use.
    scalars       : in    scalars_t := rom_scalars_c
  );
end entity gc_current_scaler;

architecture rtl of gc_current_scaler is

  constant product_bits_c : positive := force_bits_c + operand_bits_c;

  signal valid_3    : std_ulogic_vector(axes_c / turns_g - 1 downto 0);
  signal products_3 : signed(axes_c * product_bits_c - 1 downto 0);
  signal valid_4    : std_ulogic := '0';

begin

  assert axes_c mod turns_g = 0
    report "gc_current_scaler: need turns_g that divides " & integer'image(axes_c) & " axes, got "
           & integer'image(turns_g)
    severity failure;

  -- stages 1 to 3: multiply

  g_unit : for unit in 0 to axes_c / turns_g - 1 generate
    constant first_c : natural := unit * turns_g;
    constant end_c   : natural := first_c + turns_g;
  begin

    i_scale : entity work.gc_scale
      generic map (
        values_g     => turns_g,
        value_bits_g => force_bits_c,
        serial_g     => turns_g > 1
      )
      port map (
        clk          => clk,
        rst          => rst,
        in_valid     => in_valid,
        in_values    => in_force(end_c * force_bits_c - 1 downto first_c * force_bits_c),
        out_valid    => valid_3(unit),
        out_products => products_3(end_c * product_bits_c - 1 downto first_c * product_bits_c),
        factors      => scalars.current_scale(end_c * operand_bits_c - 1 downto first_c * operand_bits_c)
      );

  end generate g_unit;

  g_axis : for i in 0 to axes_c - 1 generate
    constant fraction_c  : positive := current_scale_fraction_c(i);
    constant kept_bits_c : positive := product_bits_c - fraction_c;
    constant half_c      : signed(product_bits_c - 1 downto 0) := to_signed(2 ** (fraction_c - 1), product_bits_c);
    signal   product_3   : signed(product_bits_c - 1 downto 0);
    signal   current_4   : signed(current_bits_c - 1 downto 0);
    signal   saturated_4 : std_ulogic;
  begin

    product_3 <= products_3((i + 1) * product_bits_c - 1 downto i * product_bits_c);

    -- stage 4: round and saturate
    p_round : process (clk) is

      variable current_v : signed(kept_bits_c - 1 downto 0);

    begin

      if rising_edge(clk) then
        current_v := truncate(product_3 + half_c, fraction_c, kept_bits_c);
        current_4 <= saturate(current_v, current_bits_c);
        saturated_4 <= overflows(current_v, current_bits_c);
      end if;

    end process p_round;

    out_current((i + 1) * current_bits_c - 1 downto i * current_bits_c) <= current_4;
    out_saturated(i) <= saturated_4;
  end generate g_axis;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid_4 <= valid_3(0);
      if rst = '1' then
        valid_4 <= '0';
      end if;
    end if;

  end process p_valid;

  out_valid <= valid_4;

end architecture rtl;
