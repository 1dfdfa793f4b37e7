-- SPDX-License-Identifier: MIT
--
-- f = S_o y: truncates and saturates each output sum to y, then multiplies by the output scale. In the lean form the
-- scale is part of the output weights, and y is the force.
--
-- The offset of the normalisation and the half LSBs of the two truncations are part of the output biases.
-- Formats: output_sum_bits_c -> 24 bits, mN. Latency: 3 clocks, or outputs_c + 3 with one multiplier; in the lean form
-- 1. Out_force holds until the next result. Overflow: y of y_bits_c saturates and its bit of out_saturated is set; the
-- product cannot overflow.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_output_scaler is
  generic (
    -- One multiplier for all axes, in turn.
    serial_g : boolean := false
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst           : in    std_ulogic;
    in_valid      : in    std_ulogic;
    -- Output sums, axis 1 lowest.
    in_total      : in    signed(outputs_c * output_sum_bits_c - 1 downto 0);
    out_valid     : out   std_ulogic;
    -- Forces, mN, axis 1 lowest.
    out_force     : out   signed(outputs_c * force_bits_c - 1 downto 0);
    -- Output sum of this axis did not fit y.
    out_saturated : out   std_ulogic_vector(outputs_c - 1 downto 0);
    -- Constants in use.
    scalars       : in    scalars_t := rom_scalars_c
  );
end entity gc_output_scaler;

architecture rtl of gc_output_scaler is

  constant product_bits_c : positive := 2 * operand_bits_c;
  constant kept_bits_c    : positive := output_sum_bits_c - output_drop_c;

  signal valid_1     : std_ulogic := '0';
  signal y_1         : signed(outputs_c * y_bits_c - 1 downto 0);
  signal saturated_1 : std_ulogic_vector(outputs_c - 1 downto 0);

begin

  -- stage 1: truncate and saturate; holds until the next sum, as gc_scale asks

  g_saturate : for i in 0 to outputs_c - 1 generate

    p_saturate : process (clk) is

      variable total_v : signed(kept_bits_c - 1 downto 0);

    begin

      if rising_edge(clk) then
        if in_valid = '1' then
          total_v := truncate(in_total((i + 1) * output_sum_bits_c - 1 downto i * output_sum_bits_c), output_drop_c,
                              kept_bits_c);
          y_1((i + 1) * y_bits_c - 1 downto i * y_bits_c) <= saturate(total_v, y_bits_c);
          saturated_1(i) <= overflows(total_v, y_bits_c);
        end if;
      end if;

    end process p_saturate;

  end generate g_saturate;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid_1 <= in_valid;
      if rst = '1' then
        valid_1 <= '0';
      end if;
    end if;

  end process p_valid;

  g_lean : if lean_c generate

    g_force : for i in 0 to outputs_c - 1 generate
      out_force((i + 1) * force_bits_c - 1 downto i * force_bits_c)
 <= resize(y_1((i + 1) * y_bits_c - 1 downto i * y_bits_c), force_bits_c);
    end generate g_force;

    out_valid <= valid_1;
    out_saturated <= saturated_1;
  end generate g_lean;

  g_paper : if not lean_c generate
    signal product : signed(outputs_c * product_bits_c - 1 downto 0);
  begin

    -- stages 2 and 3: multiply
    i_scale : entity work.gc_scale
      generic map (
        values_g => outputs_c,
        serial_g => serial_g
      )
      port map (
        clk          => clk,
        rst          => rst,
        in_valid     => valid_1,
        in_values    => y_1,
        out_valid    => out_valid,
        out_products => product,
        factors      => scalars.output_scale
      );

    g_force : for i in 0 to outputs_c - 1 generate
      out_force((i + 1) * force_bits_c - 1 downto i * force_bits_c)
 <= truncate(product((i + 1) * product_bits_c - 1 downto i * product_bits_c), output_scale_fraction_c(i),
             force_bits_c);
    end generate g_force;

    i_flags : entity work.gc_delay
      generic map (
        bits_g   => outputs_c,
        clocks_g => scale_latency(outputs_c, serial_g)
      )
      port map (
        clk      => clk,
        in_data  => saturated_1,
        out_data => out_saturated
      );

  end generate g_paper;

end architecture rtl;
