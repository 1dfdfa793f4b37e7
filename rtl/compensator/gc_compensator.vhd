-- SPDX-License-Identifier: MIT
--
-- f_out = f + friction(v) + mu(v) |f| + table(q): adds to the network's holding forces what depends on direction and
-- speed, and what changes too fast with the position for a network.
--
-- Position and speed are read in the clock in which the force comes in: newer than the counts that the force belongs
-- to by the latency of gc_core. With all constants zero the forces pass bit for bit.
-- Each unit of tables and multipliers takes turns_g axes, one per clock; results must then stay as many clocks apart.
-- Formats: 24 bits, mN -> 24 bits, mN. Latency: 14 clocks, and one for each further axis of a unit. Overflow: a force
-- that does not fit saturates and its bit of out_saturated is set; nothing before that can overflow.
-- Operations per axis: 5 multiplications and 5 n-ary sums, not part of the network's budget; what is zero is not built.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_compensator is
  generic (
    -- Axes that share a unit, in turn; it divides their number.
    turns_g    : positive := 1;
    -- Whether all tables are built and can be replaced, through the ports memory and scalars.
    loadable_g : boolean := false
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst           : in    std_ulogic;
    in_valid      : in    std_ulogic;
    -- Forces of the network, mN, axis 1 lowest.
    in_force      : in    signed(axes_c * force_bits_c - 1 downto 0);
    -- Encoder counts, axis 1 lowest.
    in_count      : in    signed(axes_c * count_bits_c - 1 downto 0);
    -- Clocks per 4 counts, negative when counting down, axis 1 lowest; see gc_speed_meter.
    in_period     : in    signed(axes_c * 32 - 1 downto 0);
    out_valid     : out   std_ulogic;
    -- Compensated forces, mN, axis 1 lowest.
    out_force     : out   signed(axes_c * force_bits_c - 1 downto 0);
    -- Force of this axis did not fit.
    out_saturated : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Loaded words and constants; read where loadable_g.
    memory        : in    memory_t := rom_memory_c;
    scalars       : in    scalars_t := rom_scalars_c
  );
end entity gc_compensator;

architecture rtl of gc_compensator is

  -- Holds the sum of a force, a table and a friction.
  constant total_bits_c  : positive := friction_bits_c + 1;
  constant latency_c     : positive := compensator_latency(turns_g);
  -- What goes in for an axis: its force, count, period and phase step.
  constant period_bits_c : positive := 32;
  constant count_low_c   : positive := force_bits_c;
  constant period_low_c  : positive := count_low_c + count_bits_c;
  constant step_low_c    : positive := period_low_c + period_bits_c;
  constant input_bits_c  : positive := step_low_c + phase_step_bits_c;

  signal valid : std_ulogic_vector(1 to latency_c) := (others => '0');
  signal used  : scalars_t;

begin

  assert axes_c mod turns_g = 0
    report "gc_compensator: need turns_g that divides " & integer'image(axes_c) & " axes, got "
           & integer'image(turns_g)
    severity failure;

  used <= in_use(loadable_g, scalars);

  g_unit : for unit in 0 to axes_c / turns_g - 1 generate
    constant first_c : natural := unit * turns_g;

    type forces_t is array (0 to turns_g - 1) of std_ulogic_vector(force_bits_c - 1 downto 0);

    signal inputs       : std_ulogic_vector(turns_g * input_bits_c - 1 downto 0);
    signal turn_valid   : std_ulogic;
    signal turn         : unsigned(index_bits(turns_g) - 1 downto 0);
    signal input        : std_ulogic_vector(input_bits_c - 1 downto 0);
    signal force_9      : std_ulogic_vector(force_bits_c - 1 downto 0);
    signal position_9   : operand_t;
    signal static_10    : signed(friction_bits_c - 1 downto 0);
    signal static_11    : signed(friction_bits_c - 1 downto 0);
    signal static_12    : signed(friction_bits_c - 1 downto 0);
    signal friction_12  : signed(friction_bits_c - 1 downto 0);
    signal total_13     : signed(total_bits_c - 1 downto 0);
    -- The newest last, where those before it wait for it.
    signal forces_14    : forces_t;
    signal saturated_14 : std_ulogic_vector(0 to turns_g - 1);
  begin

    g_input : for k in 0 to turns_g - 1 generate
      constant i_c    : natural := first_c + k;
      signal   effort : signed(force_bits_c - 1 downto 0);
      signal   count  : signed(count_bits_c - 1 downto 0);
      signal   period : signed(period_bits_c - 1 downto 0);
      signal   step   : signed(phase_step_bits_c - 1 downto 0);
    begin
      effort <= in_force((i_c + 1) * force_bits_c - 1 downto i_c * force_bits_c);
      count <= in_count((i_c + 1) * count_bits_c - 1 downto i_c * count_bits_c);
      period <= in_period((i_c + 1) * period_bits_c - 1 downto i_c * period_bits_c);
      step <= used.phase_step((i_c + 1) * phase_step_bits_c - 1 downto i_c * phase_step_bits_c);
      inputs((k + 1) * input_bits_c - 1 downto k * input_bits_c) <= std_ulogic_vector(step & period & count & effort);
    end generate g_input;

    i_in_turn : entity work.gc_in_turn
      generic map (
        values_g => turns_g,
        bits_g   => input_bits_c
      )
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => in_valid,
        in_values => inputs,
        out_valid => turn_valid,
        out_turn  => turn,
        out_value => input
      );

    -- stages 1 to 9: the position's part
    i_position : entity work.gc_position_table
      generic map (
        axes_g     => turns_g,
        axis_g     => first_c,
        loadable_g => loadable_g
      )
      port map (
        clk           => clk,
        rst           => rst,
        in_valid      => turn_valid,
        in_turn       => turn,
        in_count      => signed(input(count_low_c + count_bits_c - 1 downto count_low_c)),
        in_phase_step => signed(input(step_low_c + phase_step_bits_c - 1 downto step_low_c)),
        out_valid     => open,
        out_value     => position_9,
        memory        => memory
      );

    i_force : entity work.gc_delay
      generic map (
        bits_g   => force_bits_c,
        clocks_g => 9
      )
      port map (
        clk      => clk,
        in_data  => input(force_bits_c - 1 downto 0),
        out_data => force_9
      );

    -- stages 1 to 12: the speed's part
    i_friction : entity work.gc_friction
      generic map (
        axes_g     => turns_g,
        axis_g     => first_c,
        loadable_g => loadable_g
      )
      port map (
        clk          => clk,
        rst          => rst,
        in_valid     => turn_valid,
        in_turn      => turn,
        in_force     => signed(input(force_bits_c - 1 downto 0)),
        in_period    => signed(input(period_low_c + period_bits_c - 1 downto period_low_c)),
        out_valid    => open,
        out_friction => friction_12,
        memory       => memory
      );

    p_sum : process (clk) is
    begin

      if rising_edge(clk) then
        -- stages 10 to 13: add
        static_10 <= resize(signed(force_9), friction_bits_c) + position_9;
        static_11 <= static_10;
        static_12 <= static_11;
        total_13 <= resize(static_12, total_bits_c) + friction_12;
        -- stage 14: saturate
        forces_14(turns_g - 1) <= std_ulogic_vector(saturate(total_13, force_bits_c));
        saturated_14(turns_g - 1) <= overflows(total_13, force_bits_c);

        for k in 0 to turns_g - 2 loop

          forces_14(k) <= forces_14(k + 1);
          saturated_14(k) <= saturated_14(k + 1);

        end loop;

      end if;

    end process p_sum;

    g_output : for k in 0 to turns_g - 1 generate
      constant i_c : natural := first_c + k;
    begin
      out_force((i_c + 1) * force_bits_c - 1 downto i_c * force_bits_c) <= signed(forces_14(k));
      out_saturated(i_c) <= saturated_14(k);
    end generate g_output;

  end generate g_unit;

  -- All axes' forces are there with that of the last.
  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid <= in_valid & valid(1 to latency_c - 1);
      if rst = '1' then
        valid <= (others => '0');
      end if;
    end if;

  end process p_valid;

  out_valid <= valid(latency_c);

end architecture rtl;
