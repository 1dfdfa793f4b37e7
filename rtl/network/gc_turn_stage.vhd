-- SPDX-License-Identifier: MIT
--
-- Sine and cosine of every axis that turns: with a gc_phase and a gc_sin_cos each, or with one of either, in turn.
--
-- Formats: 32-bit counts -> 18 bits, x_fraction_c, truncated (half LSB in the hidden biases). Latency: 14 clocks, or
-- with one way their number + 14, and in_valid must then stay that many clocks apart; out_x holds until the next
-- result. Overflow: none, counts wrap at a turn.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_network_pkg.all;

entity gc_turn_stage is
  generic (
    -- One way from count to sine and cosine for all axes, in turn.
    shared_g : boolean := false
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears valid and state.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    -- Encoder counts of all axes, axis 1 lowest.
    in_count  : in    signed(inputs_c * count_bits_c - 1 downto 0);
    out_valid : out   std_ulogic;
    -- Sine and, above it, cosine of the axes that turn, the first lowest.
    out_x     : out   signed(2 * ones(turning_c) * operand_bits_c - 1 downto 0)
  );
end entity gc_turn_stage;

architecture rtl of gc_turn_stage is

  constant turns_c     : natural := ones(turning_c);
  constant pair_bits_c : positive := 2 * operand_bits_c;
  constant drop_c      : natural := operand_bits_c - 1 - x_fraction_c;

  -- What gc_phase takes, of the axes that turn alone.
  signal counts       : signed(turns_c * count_bits_c - 1 downto 0);
  signal coarse_steps : signed(turns_c * step_bits_c - 1 downto 0);
  signal fine_steps   : signed(turns_c * step_bits_c - 1 downto 0);
  signal pairs_valid  : std_ulogic;
  signal pairs        : signed(turns_c * pair_bits_c - 1 downto 0);
  signal x            : signed(turns_c * pair_bits_c - 1 downto 0);
  signal valid        : std_ulogic := '0';

begin

  g_axis : for i in 0 to inputs_c - 1 generate

    g_turns : if turning_c(i) = '1' generate
      constant k_c : natural := ones(turning_c(i downto 0)) - 1;
    begin
      counts((k_c + 1) * count_bits_c - 1 downto k_c * count_bits_c)
 <= in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c);
      coarse_steps((k_c + 1) * step_bits_c - 1 downto k_c * step_bits_c)
 <= coarse_step_c((i + 1) * step_bits_c - 1 downto i * step_bits_c);
      fine_steps((k_c + 1) * step_bits_c - 1 downto k_c * step_bits_c)
 <= fine_step_c((i + 1) * step_bits_c - 1 downto i * step_bits_c);
    end generate g_turns;

  end generate g_axis;

  g_parallel : if turns_c = 1 or not shared_g generate
    signal pair_valid : std_ulogic_vector(turns_c - 1 downto 0);
  begin

    g_turn : for k in 0 to turns_c - 1 generate
      signal phase_valid : std_ulogic;
      signal phase       : unsigned(phase_bits_c - 1 downto 0);
    begin

      i_phase : entity work.gc_phase
        port map (
          clk         => clk,
          rst         => rst,
          in_valid    => in_valid,
          in_count    => counts((k + 1) * count_bits_c - 1 downto k * count_bits_c),
          coarse_step => coarse_steps((k + 1) * step_bits_c - 1 downto k * step_bits_c),
          fine_step   => fine_steps((k + 1) * step_bits_c - 1 downto k * step_bits_c),
          out_valid   => phase_valid,
          out_phase   => phase
        );

      i_sin_cos : entity work.gc_sin_cos
        port map (
          clk       => clk,
          rst       => rst,
          in_valid  => phase_valid,
          in_phase  => phase,
          out_valid => pair_valid(k),
          out_sin   => pairs(k * pair_bits_c + operand_bits_c - 1 downto k * pair_bits_c),
          out_cos   => pairs((k + 1) * pair_bits_c - 1 downto k * pair_bits_c + operand_bits_c)
        );

    end generate g_turn;

    pairs_valid <= pair_valid(0);
  end generate g_parallel;

  g_shared : if turns_c > 1 and shared_g generate
    constant last_c : natural := turns_c - 1;

    signal waiting     : signed(turns_c * count_bits_c - 1 downto 0);
    signal waits       : std_ulogic := '0';
    -- The axis that goes in.
    signal turn        : std_ulogic_vector(last_c downto 0);
    signal turn_valid  : std_ulogic;
    signal count       : signed(count_bits_c - 1 downto 0);
    signal coarse_step : signed(step_bits_c - 1 downto 0);
    signal fine_step   : signed(step_bits_c - 1 downto 0);
    signal phase_valid : std_ulogic;
    signal phase       : unsigned(phase_bits_c - 1 downto 0);
    -- The one that comes out; those before the last wait for it.
    signal pair_valid  : std_ulogic;
    signal pair        : signed(pair_bits_c - 1 downto 0);
    signal arrival     : std_ulogic_vector(last_c downto 0);
    signal earlier     : signed(last_c * pair_bits_c - 1 downto 0);
  begin

    p_wait : process (clk) is
    begin

      if rising_edge(clk) then
        waits <= in_valid;
        if in_valid = '1' then
          waiting <= counts;
        end if;
        if rst = '1' then
          waits <= '0';
        end if;
      end if;

    end process p_wait;

    turn_valid <= waits or not turn(0);

    i_turn : entity work.gc_ring
      generic map (
        length_g => turns_c
      )
      port map (
        clk      => clk,
        rst      => rst,
        in_valid => turn_valid,
        out_turn => turn
      );

    -- A loop of constant slices: no synthesis tool stumbles over it.
    p_select : process (all) is
    begin

      count <= waiting(count_bits_c - 1 downto 0);
      coarse_step <= coarse_steps(step_bits_c - 1 downto 0);
      fine_step <= fine_steps(step_bits_c - 1 downto 0);

      for k in 1 to last_c loop

        if turn(k) = '1' then
          count <= waiting((k + 1) * count_bits_c - 1 downto k * count_bits_c);
          coarse_step <= coarse_steps((k + 1) * step_bits_c - 1 downto k * step_bits_c);
          fine_step <= fine_steps((k + 1) * step_bits_c - 1 downto k * step_bits_c);
        end if;

      end loop;

    end process p_select;

    i_phase : entity work.gc_phase
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => turn_valid,
        in_count    => count,
        coarse_step => coarse_step,
        fine_step   => fine_step,
        out_valid   => phase_valid,
        out_phase   => phase
      );

    i_sin_cos : entity work.gc_sin_cos
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => phase_valid,
        in_phase  => phase,
        out_valid => pair_valid,
        out_sin   => pair(operand_bits_c - 1 downto 0),
        out_cos   => pair(pair_bits_c - 1 downto operand_bits_c)
      );

    i_arrival : entity work.gc_ring
      generic map (
        length_g => turns_c
      )
      port map (
        clk      => clk,
        rst      => rst,
        in_valid => pair_valid,
        out_turn => arrival
      );

    p_collect : process (clk) is
    begin

      if rising_edge(clk) then
        if pair_valid = '1' then
          earlier <= pair & earlier(earlier'high downto pair_bits_c);
        end if;
      end if;

    end process p_collect;

    pairs <= pair & earlier;
    pairs_valid <= pair_valid and arrival(last_c);
  end generate g_shared;

  -- last stage: hold
  p_hold : process (clk) is
  begin

    if rising_edge(clk) then
      valid <= pairs_valid;
      if pairs_valid = '1' then

        for k in 0 to 2 * turns_c - 1 loop

          x((k + 1) * operand_bits_c - 1 downto k * operand_bits_c)
 <= truncate(pairs((k + 1) * operand_bits_c - 1 downto k * operand_bits_c), drop_c, operand_bits_c);

        end loop;

      end if;
      if rst = '1' then
        valid <= '0';
      end if;
    end if;

  end process p_hold;

  out_valid <= valid;
  out_x <= x;

end architecture rtl;
