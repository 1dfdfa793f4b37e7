-- SPDX-License-Identifier: MIT
--
-- Sine and cosine of a phase p = k + b, k the nearest of 1024 places of a turn and b what is left, in rad:
--
--   sin p = sin k + b cos k, cos p = cos k - b sin k
--
-- Two reads of a quarter wave, one product for b, one for each result. What the first order leaves out is at most
-- b^2 / 2 = 0.62 LSB; with the roundings both results are within 2.8 LSB (gravcomp.twin.sin_cos derives it, and a test
-- sees every phase).
-- Formats: 18 bits of a turn -> 18 bits, 17 of them fraction. Latency: 7 clocks. Overflow: results saturate at 1 - LSB.

library ieee;
  use ieee.math_real.all;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;

entity gc_sin_cos is
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    -- Part of a turn.
    in_phase  : in    unsigned(phase_bits_c - 1 downto 0);
    out_valid : out   std_ulogic;
    out_sin   : out   operand_t;
    out_cos   : out   operand_t
  );
end entity gc_sin_cos;

architecture rtl of gc_sin_cos is

  constant place_bits_c   : positive := 10;
  constant rest_bits_c    : positive := phase_bits_c - place_bits_c;
  constant address_bits_c : positive := place_bits_c - 2;
  constant product_bits_c : positive := 2 * operand_bits_c;
  -- 2 pi, with 7 fraction bits: b has phase_bits_c + 7 of them.
  constant radian_c       : operand_t := to_signed(804, operand_bits_c);
  -- Bits of a product below the LSB of the results, but one: the half LSB is added there.
  constant drop_c         : positive := phase_bits_c + 7 - 1;
  constant sum_bits_c     : positive := operand_bits_c + 2;

  subtype magnitude_t is unsigned(operand_bits_c - 2 downto 0);

  type quarter_t is array (0 to 2 ** address_bits_c - 1) of magnitude_t;

  -- sin k of the first quarter but its end, where it is the peak.

  function quarter return quarter_t is

    variable quarter_v : quarter_t;
    variable angle_v   : real;

  begin

    for k in quarter_v'range loop

      angle_v := real(k) * math_2_pi / 2.0 ** place_bits_c;
      quarter_v(k) := to_unsigned(integer(round(sin(angle_v) * 2.0 ** (operand_bits_c - 1))), operand_bits_c - 1);

    end loop;

    return quarter_v;

  end function quarter;

  constant quarter_c : quarter_t   := quarter;
  constant peak_c    : magnitude_t := (others => '1');

  function signed_by (
    magnitude   : magnitude_t;
    is_negative : std_ulogic
  ) return operand_t is

    variable value_v : operand_t;

  begin

    value_v := signed('0' & magnitude);

    if is_negative = '1' then
      value_v := -value_v;
    end if;

    return value_v;

  end function signed_by;

  signal rest       : operand_t;
  signal place_1    : unsigned(place_bits_c - 1 downto 0);
  -- The quarter wave read upwards and downwards.
  signal up_2       : magnitude_t;
  signal down_2     : magnitude_t;
  signal is_peak_2  : std_ulogic;
  signal quadrant_2 : unsigned(1 downto 0);
  signal valid_2    : std_ulogic;
  signal product_2  : signed(product_bits_c - 1 downto 0);
  signal valid_3    : std_ulogic := '0';
  -- Of sine (0) and cosine (1): at the place, what b is multiplied by, and b with its sign.
  signal place_3    : signed(2 * operand_bits_c - 1 downto 0);
  signal slope_3    : signed(2 * operand_bits_c - 1 downto 0);
  signal b_3        : signed(2 * operand_bits_c - 1 downto 0);
  signal place_4    : signed(2 * operand_bits_c - 1 downto 0);
  signal place_5    : signed(2 * operand_bits_c - 1 downto 0);
  signal valid_5    : std_ulogic_vector(1 downto 0);
  signal valid_6    : std_ulogic := '0';
  signal valid_7    : std_ulogic := '0';
  signal result_7   : signed(2 * operand_bits_c - 1 downto 0);

begin

  -- stages 1 and 2: b in rad
  rest <= resize(signed(std_ulogic_vector(in_phase(rest_bits_c - 1 downto 0))), operand_bits_c);

  i_radian : entity work.gc_multiply
    generic map (
      a_bits_g => operand_bits_c,
      b_bits_g => operand_bits_c
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => in_valid,
      in_a        => rest,
      in_b        => radian_c,
      out_valid   => valid_2,
      out_product => product_2
    );

  p_place : process (clk) is

    variable sine_v   : operand_t;
    variable cosine_v : operand_t;
    variable other_v  : magnitude_t;

  begin

    if rising_edge(clk) then
      -- stage 1: the nearest place
      place_1 <= in_phase(phase_bits_c - 1 downto rest_bits_c) + ("" & in_phase(rest_bits_c - 1));
      -- stage 2: read
      up_2 <= quarter_c(to_integer(place_1(address_bits_c - 1 downto 0)));
      down_2 <= quarter_c(to_integer(0 - place_1(address_bits_c - 1 downto 0)));
      is_peak_2 <= '0';
      if place_1(address_bits_c - 1 downto 0) = 0 then
        is_peak_2 <= '1';
      end if;
      quadrant_2 <= place_1(place_bits_c - 1 downto address_bits_c);
      -- stage 3: sine and cosine of the place
      other_v := down_2;
      if is_peak_2 = '1' then
        other_v := peak_c;
      end if;
      if quadrant_2(0) = '0' then
        sine_v := signed_by(up_2, quadrant_2(1));
        cosine_v := signed_by(other_v, quadrant_2(1));
      else
        sine_v := signed_by(other_v, quadrant_2(1));
        cosine_v := signed_by(up_2, not quadrant_2(1));
      end if;
      place_3 <= cosine_v & sine_v;
      slope_3 <= sine_v & cosine_v;
      b_3 <= (-product_2(operand_bits_c - 1 downto 0)) & product_2(operand_bits_c - 1 downto 0);
      -- stages 4 and 5: beside the products
      place_4 <= place_3;
      place_5 <= place_4;
    end if;

  end process p_place;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid_3 <= valid_2;
      valid_6 <= valid_5(0);
      valid_7 <= valid_6;
      if rst = '1' then
        valid_3 <= '0';
        valid_6 <= '0';
        valid_7 <= '0';
      end if;
    end if;

  end process p_valid;

  g_result : for i in 0 to 1 generate
    constant low_c     : natural := i * operand_bits_c;
    constant high_c    : natural := low_c + operand_bits_c - 1;
    signal   product_5 : signed(product_bits_c - 1 downto 0);
    signal   sum_6     : signed(sum_bits_c - 1 downto 0);
  begin

    -- stages 4 and 5: multiply
    i_multiply : entity work.gc_multiply
      generic map (
        a_bits_g => operand_bits_c,
        b_bits_g => operand_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_3,
        in_a        => slope_3(high_c downto low_c),
        in_b        => b_3(high_c downto low_c),
        out_valid   => valid_5(i),
        out_product => product_5
      );

    -- stages 6 and 7: add, with half an LSB; truncate and saturate
    p_add : process (clk) is
    begin

      if rising_edge(clk) then
        sum_6 <= resize(place_5(high_c downto low_c) & '1', sum_bits_c) + truncate(product_5, drop_c, sum_bits_c);
        result_7(high_c downto low_c) <= saturate(truncate(sum_6, 1, sum_bits_c - 1), operand_bits_c);
      end if;

    end process p_add;

  end generate g_result;

  out_valid <= valid_7;
  out_sin <= result_7(operand_bits_c - 1 downto 0);
  out_cos <= result_7(2 * operand_bits_c - 1 downto operand_bits_c);

end architecture rtl;
