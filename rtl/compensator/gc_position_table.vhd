-- SPDX-License-Identifier: MIT
--
-- out_value = table(position / pitch) of one axis, or of several in turn: cogging, or any other force that repeats with
-- the pitch, with its harmonics; 256 nodes per pitch, linear between them.
--
-- phase = (count * phase step) modulo 2**32, in 2**-32 of a pitch: it wraps from node 255 to node 0 and goes on
-- without a jump where the count wraps. It drifts by half of 2**-32 per count at most, the rounding of the step.
-- Formats: 32-bit counts -> 18 bits, mN, rounded. Latency: 9 clocks. Overflow: cannot happen.
-- Operations: 2 multiplications and 1 sum; tables of zeros are not built. The phase takes three multipliers of 18 bits.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;

entity gc_position_table is
  generic (
    -- Axes that come here, in turn, and the first of them.
    axes_g     : positive := 1;
    axis_g     : natural := 0;
    -- Whether the tables can be replaced, through the port memory.
    loadable_g : boolean := false
  );
  port (
    clk           : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst           : in    std_ulogic;
    in_valid      : in    std_ulogic;
    -- Whose count it is, 0 that of the first axis.
    in_turn       : in    unsigned(index_bits(axes_g) - 1 downto 0);
    -- Encoder counts, and the axis' turns of its table per count, 2**-32.
    in_count      : in    signed(count_bits_c - 1 downto 0);
    in_phase_step : in    signed(phase_step_bits_c - 1 downto 0);
    out_valid     : out   std_ulogic;
    out_value     : out   operand_t;
    -- Loaded words; read where loadable_g.
    memory        : in    memory_t := rom_memory_c
  );
end entity gc_position_table;

architecture rtl of gc_position_table is

  constant phase_bits_c : positive := 32;
  constant has_table_c  : boolean  := loadable_g or ones(position_used_c(axis_g + axes_g - 1 downto axis_g)) > 0;

  signal valid : std_ulogic_vector(1 to 9) := (others => '0');

begin

  g_table : if has_table_c generate
    signal valid_4 : std_ulogic;
    signal turn_4  : std_ulogic_vector(in_turn'range);
    signal phase_4 : signed(phase_bits_c - 1 downto 0);
  begin

    -- stages 1 to 4: multiply; whole turns fall away
    i_multiply : entity work.gc_wide_multiply
      generic map (
        a_bits_g       => count_bits_c,
        b_bits_g       => phase_step_bits_c,
        product_bits_g => phase_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_a        => in_count,
        in_b        => in_phase_step,
        out_valid   => valid_4,
        out_product => phase_4
      );

    i_turn : entity work.gc_delay
      generic map (
        bits_g   => in_turn'length,
        clocks_g => product_latency(count_bits_c, phase_step_bits_c, phase_bits_c)
      )
      port map (
        clk      => clk,
        in_data  => std_ulogic_vector(in_turn),
        out_data => turn_4
      );

    -- stages 5 to 9: look up
    i_table : entity work.gc_table
      generic map (
        address_bits_g => position_address_bits_c,
        axes_g         => axes_g,
        axis_g         => axis_g,
        table_g        => position_table(axis_g, axes_g),
        loadable_g     => loadable_g,
        section_g      => position_section_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_4,
        in_turn     => unsigned(turn_4),
        in_address  => unsigned(phase_4(31 downto 24)),
        in_fraction => unsigned(phase_4(23 downto 25 - operand_bits_c)),
        out_valid   => open,
        out_value   => out_value,
        memory      => memory
      );

  end generate g_table;

  g_no_table : if not has_table_c generate
    out_value <= (others => '0');
  end generate g_no_table;

  p_valid : process (clk) is
  begin

    if rising_edge(clk) then
      valid <= in_valid & valid(1 to valid'high - 1);
      if rst = '1' then
        valid <= (others => '0');
      end if;
    end if;

  end process p_valid;

  out_valid <= valid(valid'high);

end architecture rtl;
