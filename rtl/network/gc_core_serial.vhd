-- SPDX-License-Identifier: MIT
--
-- gc_core for small parts: the serial form of the network, on one multiplier, one sum and two block RAMs, one with the
-- words of gc_program_pkg, one with h.
--
-- a = W x + b, saturated; u = 1 - |a| / 2, the lower bits of a, inverted where a >= 0; h = sign(a) (1 - u**2), u**2 as
-- u / 2 + u t, t = u - 1/2 in the bits of a weight; f = V h + b, saturated. The ROM must be of the form serial.
-- Formats: 32-bit counts -> 24 bits, mN; operands of 18 bits, weights of weight_bits_c, sums of sum_bits_c, products
-- less output_product_drop_c bits. Latency and initiation interval, with n neurons, p features and m axes: (n + 1) (p +
-- 1) + n m + 5 clocks, n at least 6, p at least 3; 149 for 3-20-3. The forces hold until those of the next counts begin
-- to come.
-- Overflow: the sum cannot, for any count. Illegal input: counts outside the trained range are clamped and flagged; an
-- output that does not fit saturates and is flagged. Counts without in_ready are not taken.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_program_pkg.all;

entity gc_core_serial is
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high; forgets what is under way.
    rst           : in    std_ulogic;
    -- Counts are taken in a clock with in_valid and in_ready.
    in_valid      : in    std_ulogic;
    in_ready      : out   std_ulogic;
    -- Encoder counts, axis 1 lowest.
    in_count      : in    signed(inputs_c * count_bits_c - 1 downto 0);
    -- One clock per result.
    out_valid     : out   std_ulogic;
    -- Holding forces, mN, axis 1 lowest.
    out_force     : out   signed(outputs_c * force_bits_c - 1 downto 0);
    -- Count of this axis was outside the trained range.
    out_clamped   : out   std_ulogic_vector(inputs_c - 1 downto 0);
    -- Output of this axis saturated.
    out_saturated : out   std_ulogic_vector(outputs_c - 1 downto 0)
  );
end entity gc_core_serial;

architecture rtl of gc_core_serial is

  constant u_bits_c       : positive := operand_bits_c - 1;
  -- Of an operand, what goes to a multiplier of its own: with weights of 16 bits the other one fits a block of 16 x 16,
  -- registers and all, and no adder stands between a block and its register.
  constant low_bits_c     : positive := 2;
  constant product_bits_c : positive := operand_bits_c + weight_bits_c;
  constant a_bits_c       : positive := sum_bits_c - preactivation_drop_c;
  constant y_sum_bits_c   : positive := sum_bits_c - output_drop_c;

  -- Bits of t that a weight has no place for; from u to u / 2 in the sum; from the sum to h.

  function lost_bits return natural is
  begin

    if u_bits_c > weight_bits_c then
      return u_bits_c - weight_bits_c;
    end if;

    return 0;

  end function lost_bits;

  constant half_u_shift_c : natural   := u_bits_c - 1 - lost_bits - output_product_drop_c;
  constant square_drop_c  : positive  := half_u_shift_c + 1;
  constant program_c      : program_t := program;

  -- Operands of the multiplier, those that no source is zero.

  type operands_t is array (0 to 2 ** source_bits_c - 1) of operand_t;

  signal running    : std_ulogic := '0';
  signal step       : unsigned(address_bits_c - 1 downto 0) := (others => '0');
  signal word       : word_t;
  signal slot       : slot_t;
  signal accept     : std_ulogic;
  signal multiplies : std_ulogic;
  signal takes_a    : std_ulogic;
  signal takes_y    : std_ulogic;
  signal reads      : unsigned(neuron_bits_c - 1 downto 0);
  signal x          : signed(features_c * operand_bits_c - 1 downto 0);
  signal operands   : operands_t;
  signal operand    : operand_t;
  signal low        : signed(low_bits_c downto 0);
  signal h_word     : std_ulogic_vector(operand_bits_c - 1 downto 0);
  signal t          : signed(u_bits_c - 1 downto 0);
  signal factor     : signed(weight_bits_c - 1 downto 0);
  signal high_2     : signed(product_bits_c - low_bits_c - 1 downto 0);
  signal low_2      : signed(weight_bits_c + low_bits_c downto 0);
  signal product_3  : signed(product_bits_c - 1 downto 0);
  signal sum        : signed(sum_bits_c - 1 downto 0);
  signal a          : operand_t;
  signal u          : unsigned(u_bits_c - 1 downto 0);
  -- Whether a < 0, beside u and beside its square.
  signal is_below   : std_ulogic;
  signal is_below_1 : std_ulogic;
  signal square     : unsigned(u_bits_c - 1 downto 0);
  signal h          : std_ulogic_vector(operand_bits_c - 1 downto 0);
  signal y_sum      : signed(y_sum_bits_c - 1 downto 0);
  signal y          : signed(outputs_c * y_bits_c - 1 downto 0);
  signal saturated  : std_ulogic_vector(outputs_c - 1 downto 0);
  signal valid      : std_ulogic := '0';

begin

  assert serial_form_c
    report "gc_core_serial: need a ROM of the form serial, got another; take gc_core"
    severity failure;

  in_ready <= not running;
  accept <= in_valid and not running;

  -- The step rests at 0, so that its word is out in the clock after counts are taken.
  p_step : process (clk) is
  begin

    if rising_edge(clk) then
      word <= program_c(to_integer(step));
      valid <= slot.ends and running;
      if accept = '1' then
        running <= '1';
      end if;
      if accept = '1' or running = '1' then
        step <= step + 1;
      end if;
      if (slot.ends and running) = '1' or rst = '1' then
        running <= '0';
        step <= (others => '0');
      end if;
      if rst = '1' then
        valid <= '0';
      end if;
    end if;

  end process p_step;

  slot <= to_slot(word);
  multiplies <= slot.multiplies and running;
  takes_a <= slot.takes_a and running;
  takes_y <= slot.takes_y and running;
  -- The first word comes with the first clock: until then a simulator would warn of its bits.
  reads <= to_01(slot.reads);

  -- x holds until the next counts are taken.
  i_input_scaler : entity work.gc_input_scaler
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => accept,
      in_count    => in_count,
      out_valid   => open,
      out_x       => x,
      out_clamped => out_clamped
    );

  g_operand : for i in operands_t'range generate

    g_x : if i < features_c generate
      operands(i) <= x((i + 1) * operand_bits_c - 1 downto i * operand_bits_c);
    end generate g_x;

    g_h : if i = source_h_c generate
      operands(i) <= signed(h_word);
    end generate g_h;

    g_u : if i = source_u_c generate
      operands(i) <= signed('0' & std_ulogic_vector(u));
    end generate g_u;

    g_none : if i > source_u_c generate
      operands(i) <= (others => '0');
    end generate g_none;

  end generate g_operand;

  operand <= operands(to_integer(slot.source));
  low <= signed('0' & std_ulogic_vector(operand(low_bits_c - 1 downto 0)));

  -- u less a half: its top bit inverted is the sign.
  t <= signed(not u(u_bits_c - 1) & std_ulogic_vector(u(u_bits_c - 2 downto 0)));
  factor <= truncate(t, lost_bits, weight_bits_c) when slot.source = source_u_c else
            slot.weight;

  i_multiply : entity work.gc_multiply
    generic map (
      a_bits_g => operand_bits_c - low_bits_c,
      b_bits_g => weight_bits_c
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => multiplies,
      in_a        => operand(operand_bits_c - 1 downto low_bits_c),
      in_b        => factor,
      out_valid   => open,
      out_product => high_2
    );

  i_low : entity work.gc_multiply
    generic map (
      a_bits_g => low_bits_c + 1,
      b_bits_g => weight_bits_c
    )
    port map (
      clk         => clk,
      rst         => rst,
      in_valid    => multiplies,
      in_a        => low,
      in_b        => factor,
      out_valid   => open,
      out_product => low_2
    );

  p_product : process (clk) is
  begin

    if rising_edge(clk) then
      product_3 <= shift_left(resize(high_2, product_bits_c), low_bits_c) + low_2;
    end if;

  end process p_product;

  p_sum : process (clk) is

    variable base_v : signed(sum_bits_c - 1 downto 0);

  begin

    if rising_edge(clk) then
      base_v := sum;
      if slot.starts = '1' then
        base_v := slot.bias;
      elsif slot.squares = '1' then
        base_v := shift_left(resize(signed('0' & std_ulogic_vector(u)), sum_bits_c), half_u_shift_c);
      end if;
      sum <= base_v + truncate(product_3, output_product_drop_c, sum_bits_c);
    end if;

  end process p_sum;

  a <= saturate(truncate(sum, preactivation_drop_c, a_bits_c), operand_bits_c);

  p_u : process (clk) is
  begin

    if rising_edge(clk) then
      if takes_a = '1' then
        u <= unsigned(a(u_bits_c - 1 downto 0) xor (u_bits_c - 1 downto 0 => not a(u_bits_c)));
        is_below <= a(u_bits_c);
      end if;
      is_below_1 <= is_below;
    end if;

  end process p_u;

  square <= unsigned(sum(square_drop_c + u_bits_c - 1 downto square_drop_c));
  h <= is_below_1 & std_ulogic_vector(square xor (u_bits_c - 1 downto 0 => not is_below_1));

  i_h : entity work.gc_bank_ram
    generic map (
      word_bits_g    => operand_bits_c,
      address_bits_g => neuron_bits_c
    )
    port map (
      clk           => clk,
      in_write      => slot.takes_h,
      in_write_bank => '0',
      in_write_addr => slot.writes,
      in_word       => h,
      in_bank       => '0',
      in_addr       => reads,
      out_word      => h_word
    );

  -- The first output goes down one place with each that follows.
  y_sum <= truncate(sum, output_drop_c, y_sum_bits_c);

  p_y : process (clk) is
  begin

    if rising_edge(clk) then
      if takes_y = '1' then
        y <= saturate(y_sum, y_bits_c) & y(y'high downto y_bits_c);
        saturated <= overflows(y_sum, y_bits_c) & saturated(saturated'high downto 1);
      end if;
    end if;

  end process p_y;

  out_valid <= valid;
  out_saturated <= saturated;

  g_force : for i in 0 to outputs_c - 1 generate
    out_force((i + 1) * force_bits_c - 1 downto i * force_bits_c)
 <= resize(y((i + 1) * y_bits_c - 1 downto i * y_bits_c), force_bits_c);
  end generate g_force;

end architecture rtl;
