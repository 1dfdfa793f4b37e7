-- SPDX-License-Identifier: MIT
--
-- out_value = table(position / pitch) of one axis: cogging, or any other force that repeats with the pitch, with its
-- harmonics; 256 nodes per pitch, linear between them.
--
-- phase = (count * phase step) modulo 2**32, in 2**-32 of a pitch: it wraps from node 255 to node 0 and goes on
-- without a jump where the count wraps. It drifts by half of 2**-32 per count at most, the rounding of the step.
-- Formats: 32-bit counts -> 18 bits, mN, rounded. Latency: 7 clocks. Overflow: cannot happen.
-- Operations: 2 multiplications and 1 sum; a table of zeros is not built.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_position_table is
  generic (
    -- Which axis, 0 the first.
    axis_g     : natural := 0;
    -- Whether the table can be replaced, through the port memory.
    loadable_g : boolean := false
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    -- Encoder counts.
    in_count  : in    signed(count_bits_c - 1 downto 0);
    out_valid : out   std_ulogic;
    out_value : out   operand_t;
    -- Loaded words; read where loadable_g.
    memory    : in    memory_t := rom_memory_c;
    -- Constants in use.
    scalars   : in    scalars_t := rom_scalars_c
  );
end entity gc_position_table;

architecture rtl of gc_position_table is

  constant has_table_c : boolean := loadable_g or position_used_c(axis_g) = '1';

  signal valid : std_ulogic_vector(1 to 7) := (others => '0');

begin

  g_table : if has_table_c generate
    signal valid_2   : std_ulogic;
    signal product_2 : signed(count_bits_c + phase_step_bits_c - 1 downto 0);
    signal valid_3   : std_ulogic := '0';
    signal phase_3   : unsigned(31 downto 0) := (others => '0');
  begin

    -- stages 1 and 2: multiply
    i_multiply : entity work.gc_multiply
      generic map (
        a_bits_g => count_bits_c,
        b_bits_g => phase_step_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => in_valid,
        in_a        => in_count,
        in_b        => scalars.phase_step((axis_g + 1) * phase_step_bits_c - 1 downto axis_g * phase_step_bits_c),
        out_valid   => valid_2,
        out_product => product_2
      );

    -- stage 3: whole turns fall away
    p_phase : process (clk) is
    begin

      if rising_edge(clk) then
        valid_3 <= valid_2;
        if valid_2 = '1' then
          phase_3 <= unsigned(product_2(31 downto 0));
        end if;
        if rst = '1' then
          valid_3 <= '0';
        end if;
      end if;

    end process p_phase;

    -- stages 4 to 7: look up
    i_table : entity work.gc_table
      generic map (
        address_bits_g => position_address_bits_c,
        table_g        => position_table(axis_g),
        loadable_g     => loadable_g,
        axis_g         => axis_g,
        section_g      => position_section_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_3,
        in_address  => phase_3(31 downto 24),
        in_fraction => phase_3(23 downto 25 - operand_bits_c),
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
      valid <= in_valid & valid(1 to 6);
      if rst = '1' then
        valid <= (others => '0');
      end if;
    end if;

  end process p_valid;

  out_valid <= valid(7);

end architecture rtl;
