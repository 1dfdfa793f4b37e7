-- SPDX-License-Identifier: MIT
--
-- out_friction = friction(v) + mu(v) |f| of one axis, or of several in turn: Coulomb by direction, Stribeck, viscous
-- and load-dependent friction, as two tables over the signed speed.
--
-- At standstill, while the speed is unknown (start, reversal, dither about one edge) and in the dead band both tables
-- are zero: friction rises from zero with the speed and cannot chatter at rest.
-- Formats: 24 bits, mN -> 25 bits, mN, rounded. Latency: 12 clocks. Overflow: cannot happen.
-- Operations: 3 multiplications and 3 sums; tables of zeros are not built. The load takes two multipliers of 18 bits.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;

entity gc_friction is
  generic (
    -- Axes that come here, in turn, and the first of them.
    axes_g     : positive := 1;
    axis_g     : natural := 0;
    -- Whether the tables can be replaced, through the port memory.
    loadable_g : boolean := false
  );
  port (
    clk          : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst          : in    std_ulogic;
    in_valid     : in    std_ulogic;
    -- Whose force and period it is, 0 those of the first axis.
    in_turn      : in    unsigned(index_bits(axes_g) - 1 downto 0);
    -- Force of the network, mN.
    in_force     : in    signed(force_bits_c - 1 downto 0);
    -- Clocks per 4 counts, negative when counting down; see gc_speed_meter.
    in_period    : in    signed(31 downto 0);
    out_valid    : out   std_ulogic;
    out_friction : out   signed(friction_bits_c - 1 downto 0);
    -- Loaded words; read where loadable_g.
    memory       : in    memory_t := rom_memory_c
  );
end entity gc_friction;

architecture rtl of gc_friction is

  constant last_c        : natural  := axis_g + axes_g - 1;
  constant load_bits_c   : positive := force_bits_c + 1 + operand_bits_c;
  constant mu_fraction_c : positive := operand_bits_c - 1;
  constant has_sliding_c : boolean  := loadable_g or ones(friction_used_c(last_c downto axis_g)) > 0;
  constant has_load_c    : boolean  := loadable_g or ones(mu_used_c(last_c downto axis_g)) > 0;

  signal valid       : std_ulogic_vector(1 to 12) := (others => '0');
  signal valid_3     : std_ulogic;
  signal turn_3      : std_ulogic_vector(in_turn'range);
  signal address_3   : unsigned(speed_address_bits_c - 1 downto 0);
  signal fraction_3  : unsigned(operand_bits_c - 2 downto 0);
  signal sliding_8   : operand_t;
  signal sliding_11  : std_ulogic_vector(operand_bits_c - 1 downto 0);
  signal load_11     : signed(load_bits_c - 1 downto 0);
  signal friction_12 : signed(friction_bits_c - 1 downto 0);

begin

  -- stages 1 to 3: the place in the tables
  i_speed_code : entity work.gc_speed_code
    port map (
      clk          => clk,
      rst          => rst,
      in_valid     => in_valid,
      in_period    => in_period,
      out_valid    => valid_3,
      out_address  => address_3,
      out_fraction => fraction_3
    );

  i_turn : entity work.gc_delay
    generic map (
      bits_g   => in_turn'length,
      clocks_g => 3
    )
    port map (
      clk      => clk,
      in_data  => std_ulogic_vector(in_turn),
      out_data => turn_3
    );

  -- stages 4 to 8: look up

  g_sliding : if has_sliding_c generate

    i_sliding : entity work.gc_table
      generic map (
        address_bits_g => speed_address_bits_c,
        axes_g         => axes_g,
        axis_g         => axis_g,
        table_g        => speed_table(friction_words_c, axis_g, axes_g),
        loadable_g     => loadable_g,
        section_g      => friction_section_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_3,
        in_turn     => unsigned(turn_3),
        in_address  => address_3,
        in_fraction => fraction_3,
        out_valid   => open,
        out_value   => sliding_8,
        memory      => memory
      );

  end generate g_sliding;

  g_no_sliding : if not has_sliding_c generate
    sliding_8 <= (others => '0');
  end generate g_no_sliding;

  g_load : if has_load_c generate
    signal mu_8        : operand_t;
    signal valid_8     : std_ulogic;
    signal force_7     : std_ulogic_vector(force_bits_c - 1 downto 0);
    signal magnitude_8 : signed(force_bits_c downto 0);
  begin

    i_mu : entity work.gc_table
      generic map (
        address_bits_g => speed_address_bits_c,
        axes_g         => axes_g,
        axis_g         => axis_g,
        table_g        => speed_table(mu_words_c, axis_g, axes_g),
        loadable_g     => loadable_g,
        section_g      => mu_section_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_3,
        in_turn     => unsigned(turn_3),
        in_address  => address_3,
        in_fraction => fraction_3,
        out_valid   => valid_8,
        out_value   => mu_8,
        memory      => memory
      );

    i_force : entity work.gc_delay
      generic map (
        bits_g   => force_bits_c,
        clocks_g => 7
      )
      port map (
        clk      => clk,
        in_data  => std_ulogic_vector(in_force),
        out_data => force_7
      );

    p_magnitude : process (clk) is
    begin

      if rising_edge(clk) then
        magnitude_8 <= resize(signed(force_7), force_bits_c + 1);
        if force_7(force_7'high) = '1' then
          magnitude_8 <= -resize(signed(force_7), force_bits_c + 1);
        end if;
      end if;

    end process p_magnitude;

    -- stages 9 to 11: multiply
    i_multiply : entity work.gc_wide_multiply
      generic map (
        a_bits_g       => force_bits_c + 1,
        b_bits_g       => operand_bits_c,
        product_bits_g => load_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_8,
        in_a        => magnitude_8,
        in_b        => mu_8,
        out_valid   => open,
        out_product => load_11
      );

  end generate g_load;

  g_no_load : if not has_load_c generate
    load_11 <= (others => '0');
  end generate g_no_load;

  i_sliding_waits : entity work.gc_delay
    generic map (
      bits_g   => operand_bits_c,
      clocks_g => product_latency(force_bits_c + 1, operand_bits_c, load_bits_c)
    )
    port map (
      clk      => clk,
      in_data  => std_ulogic_vector(sliding_8),
      out_data => sliding_11
    );

  -- stage 12: add both and half an LSB, which is the next bit below the sliding friction
  p_sum : process (clk) is

    variable sliding_v : signed(load_bits_c - 1 downto 0);

  begin

    if rising_edge(clk) then
      sliding_v := shift_left(resize(signed(sliding_11), load_bits_c), mu_fraction_c);
      sliding_v(mu_fraction_c - 1) := '1';
      friction_12 <= truncate(sliding_v + load_11, mu_fraction_c, friction_bits_c);
      valid <= in_valid & valid(1 to valid'high - 1);
      if rst = '1' then
        valid <= (others => '0');
      end if;
    end if;

  end process p_sum;

  out_valid <= valid(valid'high);
  out_friction <= friction_12;

end architecture rtl;
