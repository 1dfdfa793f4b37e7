-- SPDX-License-Identifier: MIT
--
-- phase = count / counts_per_turn modulo a turn: a joint that turns for ever wraps for free.
--
-- The count is split in halves, c = 2^16 h + l; of either half the steps tell its part of a turn, in two parts that fit
-- an operand each: four products of 18 bits, one sum, of which whatever is beyond a turn falls away.
-- Formats: 32-bit count -> 18 bits of a turn, rounded. Latency: 6 clocks. Overflow: none, it wraps. The steps are
-- rounded to half their LSB: over all counts the phase is within 7/8 of its LSB.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;

entity gc_phase is
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst         : in    std_ulogic;
    in_valid    : in    std_ulogic;
    -- Encoder count.
    in_count    : in    signed(count_bits_c - 1 downto 0);
    -- Turns per 2^16 counts and per count, modulo a turn, step_bits_c fraction bits.
    coarse_step : in    signed(step_bits_c - 1 downto 0);
    fine_step   : in    signed(step_bits_c - 1 downto 0);
    out_valid   : out   std_ulogic;
    -- Part of a turn.
    out_phase   : out   unsigned(phase_bits_c - 1 downto 0)
  );
end entity gc_phase;

architecture rtl of gc_phase is

  constant half_bits_c    : positive := count_bits_c / 2;
  -- A step: an operand above, and so many bits below, which are an operand with a sign bit of 0.
  constant lower_bits_c   : positive := operand_bits_c - 1;
  constant product_bits_c : positive := 2 * operand_bits_c;
  constant drop_c         : positive := step_bits_c - phase_bits_c;
  -- Half an LSB of the phase, the last term.
  constant half_lsb_c     : signed(step_bits_c - 1 downto 0) := to_signed(2 ** (drop_c - 1), step_bits_c);
  constant terms_c        : positive := 5;

  -- Low half and high half of the count, and the steps that belong to them.
  signal half    : signed(2 * operand_bits_c - 1 downto 0);
  signal step    : signed(2 * step_bits_c - 1 downto 0);
  signal valid_2 : std_ulogic_vector(3 downto 0);
  signal terms_2 : signed(terms_c * step_bits_c - 1 downto 0);
  signal sum     : signed(step_bits_c - 1 downto 0);

begin

  half <= resize(in_count(count_bits_c - 1 downto half_bits_c), operand_bits_c)
          & resize(signed('0' & std_ulogic_vector(in_count(half_bits_c - 1 downto 0))), operand_bits_c);
  step <= coarse_step & fine_step;

  -- stages 1 and 2: multiply

  g_half : for i in 0 to 1 generate

    -- 0: by the lower bits of the step, 1: by the upper ones.

    g_part : for k in 0 to 1 generate
      constant term_c    : natural := 2 * i + k;
      constant low_c     : natural := i * step_bits_c;
      signal   part      : operand_t;
      signal   product_2 : signed(product_bits_c - 1 downto 0);
      signal   term_2    : signed(step_bits_c - 1 downto 0);
    begin

      g_lower : if k = 0 generate
        part <= signed('0' & std_ulogic_vector(step(low_c + lower_bits_c - 1 downto low_c)));
        term_2 <= resize(product_2, step_bits_c);
      end generate g_lower;

      g_upper : if k = 1 generate
        part <= step(low_c + step_bits_c - 1 downto low_c + lower_bits_c);
        term_2(step_bits_c - 1 downto lower_bits_c) <= product_2(operand_bits_c - 1 downto 0);
        term_2(lower_bits_c - 1 downto 0) <= (others => '0');
      end generate g_upper;

      i_multiply : entity work.gc_multiply
        generic map (
          a_bits_g => operand_bits_c,
          b_bits_g => operand_bits_c
        )
        port map (
          clk         => clk,
          rst         => rst,
          in_valid    => in_valid,
          in_a        => half((i + 1) * operand_bits_c - 1 downto i * operand_bits_c),
          in_b        => part,
          out_valid   => valid_2(term_c),
          out_product => product_2
        );

      terms_2((term_c + 1) * step_bits_c - 1 downto term_c * step_bits_c) <= term_2;
    end generate g_part;

  end generate g_half;

  terms_2(terms_c * step_bits_c - 1 downto (terms_c - 1) * step_bits_c) <= half_lsb_c;

  -- stages 3 to 6: sum
  i_sum : entity work.gc_adder_tree
    generic map (
      terms_g => terms_c,
      bits_g  => step_bits_c
    )
    port map (
      clk       => clk,
      rst       => rst,
      in_valid  => valid_2(0),
      in_terms  => terms_2,
      out_valid => out_valid,
      out_sum   => sum
    );

  out_phase <= unsigned(sum(step_bits_c - 1 downto drop_c));

end architecture rtl;
