-- SPDX-License-Identifier: MIT
--
-- f_out = f + friction(v) + mu(v) |f| + table(q): adds to the network's holding forces what depends on direction and
-- speed, and what changes too fast with the position for a network.
--
-- Position and speed are read in the clock in which the force comes in: newer than the counts that the force belongs
-- to by the latency of gc_core. With all constants zero the forces pass bit for bit.
-- Formats: 24 bits, mN -> 24 bits, mN. Latency: 12 clocks, one result per clock. Overflow: a force that does not fit
-- saturates and its bit of out_saturated is set; nothing before that can overflow.
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
  constant total_bits_c : positive := friction_bits_c + 1;

  signal valid_10     : std_ulogic_vector(axes_c - 1 downto 0);
  signal valid_11     : std_ulogic := '0';
  signal valid_12     : std_ulogic := '0';
  signal force_12     : signed(axes_c * force_bits_c - 1 downto 0);
  signal saturated_12 : std_ulogic_vector(axes_c - 1 downto 0);
  signal used         : scalars_t;

begin

  used <= in_use(loadable_g, scalars);

  g_axis : for i in 0 to axes_c - 1 generate
    signal force_7     : std_ulogic_vector(force_bits_c - 1 downto 0);
    signal position_7  : operand_t;
    signal static_8    : signed(friction_bits_c - 1 downto 0);
    signal static_9    : signed(friction_bits_c - 1 downto 0);
    signal static_10   : signed(friction_bits_c - 1 downto 0);
    signal friction_10 : signed(friction_bits_c - 1 downto 0);
    signal total_11    : signed(total_bits_c - 1 downto 0);
  begin

    -- stages 1 to 7: the position's part
    i_position : entity work.gc_position_table
      generic map (
        axis_g     => i,
        loadable_g => loadable_g
      )
      port map (
        clk       => clk,
        rst       => rst,
        in_valid  => in_valid,
        in_count  => in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c),
        out_valid => open,
        out_value => position_7,
        memory    => memory,
        scalars   => used
      );

    i_force : entity work.gc_delay
      generic map (
        bits_g   => force_bits_c,
        clocks_g => 7
      )
      port map (
        clk      => clk,
        in_data  => std_ulogic_vector(in_force((i + 1) * force_bits_c - 1 downto i * force_bits_c)),
        out_data => force_7
      );

    -- stages 1 to 10: the speed's part
    i_friction : entity work.gc_friction
      generic map (
        axis_g     => i,
        loadable_g => loadable_g
      )
      port map (
        clk          => clk,
        rst          => rst,
        in_valid     => in_valid,
        in_force     => in_force((i + 1) * force_bits_c - 1 downto i * force_bits_c),
        in_period    => in_period((i + 1) * 32 - 1 downto i * 32),
        out_valid    => valid_10(i),
        out_friction => friction_10,
        memory       => memory
      );

    p_sum : process (clk) is
    begin

      if rising_edge(clk) then
        -- stages 8 to 11: add
        static_8 <= resize(signed(force_7), friction_bits_c) + position_7;
        static_9 <= static_8;
        static_10 <= static_9;
        total_11 <= resize(static_10, total_bits_c) + friction_10;
        -- stage 12: saturate
        force_12((i + 1) * force_bits_c - 1 downto i * force_bits_c) <= saturate(total_11, force_bits_c);
        saturated_12(i) <= overflows(total_11, force_bits_c);
      end if;

    end process p_sum;

  end generate g_axis;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid_11 <= valid_10(0);
      valid_12 <= valid_11;
      if rst = '1' then
        valid_11 <= '0';
        valid_12 <= '0';
      end if;
    end if;

  end process p_valid;

  out_valid <= valid_12;
  out_force <= force_12;
  out_saturated <= saturated_12;

end architecture rtl;
