-- SPDX-License-Identifier: MIT
--
-- out_products(i) = in_values(i) * factors(i) for n values: with n multipliers at once, or with one, in turn.
--
-- With one multiplier value k is read k clocks after in_valid: it holds until then, or comes then. out_products hold
-- from out_valid as long as in_values did, with one multiplier to the next out_valid.
-- Formats: value_bits_g x 18 -> that and 18 bits, value 0 lowest in the vectors. Latency: that of gc_wide_multiply, 2
-- clocks for values of 18 bits; with one multiplier values_g more, and in_valid must then stay values_g clocks apart.
-- Overflow: cannot happen.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;

entity gc_scale is
  generic (
    -- Number of values.
    values_g     : positive := 3;
    -- Width of a value, bits.
    value_bits_g : positive := operand_bits_c;
    -- One multiplier for all values, in turn.
    serial_g     : boolean := false
  );
  port (
    clk          : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst          : in    std_ulogic;
    in_valid     : in    std_ulogic;
    in_values    : in    signed(values_g * value_bits_g - 1 downto 0);
    out_valid    : out   std_ulogic;
    out_products : out   signed(values_g * (value_bits_g + operand_bits_c) - 1 downto 0);
    -- Factor 0 lowest; they change only while no product is under way.
    factors      : in    signed(values_g * operand_bits_c - 1 downto 0)
  );
end entity gc_scale;

architecture rtl of gc_scale is

  constant product_bits_c : positive := value_bits_g + operand_bits_c;

begin

  g_parallel : if values_g = 1 or not serial_g generate
    signal valid : std_ulogic_vector(values_g - 1 downto 0);
  begin

    g_value : for i in 0 to values_g - 1 generate

      i_multiply : entity work.gc_wide_multiply
        generic map (
          a_bits_g       => value_bits_g,
          b_bits_g       => operand_bits_c,
          product_bits_g => product_bits_c
        )
        port map (
          clk         => clk,
          rst         => rst,
          in_valid    => in_valid,
          in_a        => in_values((i + 1) * value_bits_g - 1 downto i * value_bits_g),
          in_b        => factors((i + 1) * operand_bits_c - 1 downto i * operand_bits_c),
          out_valid   => valid(i),
          out_product => out_products((i + 1) * product_bits_c - 1 downto i * product_bits_c)
        );

    end generate g_value;

    out_valid <= valid(0);
  end generate g_parallel;

  g_serial : if values_g > 1 and serial_g generate
    constant last_c      : positive := values_g - 1;
    -- Bit k: values came k clocks ago. So value k goes in, and later the last product comes out.
    constant out_c       : positive := scale_latency(values_g, true, value_bits_g) - 1;
    signal   turn        : std_ulogic_vector(0 to out_c);
    signal   then_valid  : std_ulogic_vector(1 to out_c) := (others => '0');
    signal   value       : signed(value_bits_g - 1 downto 0);
    signal   factor      : operand_t;
    signal   value_valid : std_ulogic;
    signal   product     : signed(product_bits_c - 1 downto 0);
    -- Products before the last wait for it.
    signal   waiting     : signed(last_c * product_bits_c - 1 downto 0);
    signal   products    : signed(values_g * product_bits_c - 1 downto 0);
    signal   valid       : std_ulogic := '0';
  begin

    turn <= in_valid & then_valid;
    value_valid <= '1' when ones(turn(0 to last_c)) > 0 else '0';

    p_turn : process (clk) is
    begin

      if rising_edge(clk) then
        then_valid <= turn(0 to out_c - 1);
        if rst = '1' then
          then_valid <= (others => '0');
        end if;
      end if;

    end process p_turn;

    -- A loop of constant slices: no synthesis tool stumbles over it.
    p_select : process (all) is
    begin

      value <= in_values(value_bits_g - 1 downto 0);
      factor <= factors(operand_bits_c - 1 downto 0);

      for i in 1 to last_c loop

        if turn(i) = '1' then
          value <= in_values((i + 1) * value_bits_g - 1 downto i * value_bits_g);
          factor <= factors((i + 1) * operand_bits_c - 1 downto i * operand_bits_c);
        end if;

      end loop;

    end process p_select;

    i_multiply : entity work.gc_wide_multiply
      generic map (
        a_bits_g       => value_bits_g,
        b_bits_g       => operand_bits_c,
        product_bits_g => product_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => value_valid,
        in_a        => value,
        in_b        => factor,
        out_valid   => open,
        out_product => product
      );

    p_collect : process (clk) is

      variable all_v : signed(products'range);

    begin

      if rising_edge(clk) then
        all_v := product & waiting;
        waiting <= all_v(all_v'high downto product_bits_c);
        if turn(out_c) = '1' then
          products <= all_v;
        end if;
        valid <= turn(out_c);
        if rst = '1' then
          valid <= '0';
        end if;
      end if;

    end process p_collect;

    out_valid <= valid;
    out_products <= products;
  end generate g_serial;

end architecture rtl;
