-- SPDX-License-Identifier: MIT
--
-- out_friction = friction(v) + mu(v) |f| of one axis: Coulomb by direction, Stribeck, viscous and load-dependent
-- friction, as two tables over the signed speed.
--
-- At standstill, while the speed is unknown (start, reversal, dither about one edge) and in the dead band both tables
-- are zero: friction rises from zero with the speed and cannot chatter at rest.
-- Formats: 24 bits, mN -> 25 bits, mN, rounded. Latency: 10 clocks. Overflow: cannot happen.
-- Operations: 3 multiplications and 3 sums; a table of zeros is not built.

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
    -- Which axis, 0 the first.
    axis_g     : natural := 0;
    -- Whether the tables can be replaced, through the port memory.
    loadable_g : boolean := false
  );
  port (
    clk          : in    std_ulogic;
    -- Synchronous, active high; clears the valid bits.
    rst          : in    std_ulogic;
    in_valid     : in    std_ulogic;
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

  constant load_bits_c   : positive := force_bits_c + 1 + operand_bits_c;
  constant mu_fraction_c : positive := operand_bits_c - 1;
  constant has_sliding_c : boolean  := loadable_g or friction_used_c(axis_g) = '1';
  constant has_load_c    : boolean  := loadable_g or mu_used_c(axis_g) = '1';

  signal valid       : std_ulogic_vector(1 to 10) := (others => '0');
  signal valid_3     : std_ulogic;
  signal address_3   : unsigned(speed_address_bits_c - 1 downto 0);
  signal fraction_3  : unsigned(operand_bits_c - 2 downto 0);
  signal sliding_7   : operand_t;
  signal sliding_8   : operand_t;
  signal sliding_9   : operand_t;
  signal load_9      : signed(load_bits_c - 1 downto 0);
  signal friction_10 : signed(friction_bits_c - 1 downto 0);

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

  -- stages 4 to 7: look up

  g_sliding : if has_sliding_c generate

    i_sliding : entity work.gc_table
      generic map (
        address_bits_g => speed_address_bits_c,
        table_g        => speed_table(friction_words_c, axis_g),
        loadable_g     => loadable_g,
        axis_g         => axis_g,
        section_g      => friction_section_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_3,
        in_address  => address_3,
        in_fraction => fraction_3,
        out_valid   => open,
        out_value   => sliding_7,
        memory      => memory
      );

  end generate g_sliding;

  g_no_sliding : if not has_sliding_c generate
    sliding_7 <= (others => '0');
  end generate g_no_sliding;

  g_load : if has_load_c generate
    signal mu_7        : operand_t;
    signal valid_7     : std_ulogic;
    signal force_6     : std_ulogic_vector(force_bits_c - 1 downto 0);
    signal magnitude_7 : signed(force_bits_c downto 0);
  begin

    i_mu : entity work.gc_table
      generic map (
        address_bits_g => speed_address_bits_c,
        table_g        => speed_table(mu_words_c, axis_g),
        loadable_g     => loadable_g,
        axis_g         => axis_g,
        section_g      => mu_section_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_3,
        in_address  => address_3,
        in_fraction => fraction_3,
        out_valid   => valid_7,
        out_value   => mu_7,
        memory      => memory
      );

    i_force : entity work.gc_delay
      generic map (
        bits_g   => force_bits_c,
        clocks_g => 6
      )
      port map (
        clk      => clk,
        in_data  => std_ulogic_vector(in_force),
        out_data => force_6
      );

    p_magnitude : process (clk) is
    begin

      if rising_edge(clk) then
        magnitude_7 <= resize(signed(force_6), force_bits_c + 1);
        if force_6(force_6'high) = '1' then
          magnitude_7 <= -resize(signed(force_6), force_bits_c + 1);
        end if;
      end if;

    end process p_magnitude;

    -- stages 8 and 9: multiply
    i_multiply : entity work.gc_multiply
      generic map (
        a_bits_g => force_bits_c + 1,
        b_bits_g => operand_bits_c
      )
      port map (
        clk         => clk,
        rst         => rst,
        in_valid    => valid_7,
        in_a        => magnitude_7,
        in_b        => mu_7,
        out_valid   => open,
        out_product => load_9
      );

  end generate g_load;

  g_no_load : if not has_load_c generate
    load_9 <= (others => '0');
  end generate g_no_load;

  -- stage 10: add both and half an LSB, which is the next bit below the sliding friction
  p_sum : process (clk) is

    variable sliding_v : signed(load_bits_c - 1 downto 0);

  begin

    if rising_edge(clk) then
      sliding_8 <= sliding_7;
      sliding_9 <= sliding_8;
      sliding_v := shift_left(resize(sliding_9, load_bits_c), mu_fraction_c);
      sliding_v(mu_fraction_c - 1) := '1';
      friction_10 <= truncate(sliding_v + load_9, mu_fraction_c, friction_bits_c);
      valid <= in_valid & valid(1 to 9);
      if rst = '1' then
        valid <= (others => '0');
      end if;
    end if;

  end process p_sum;

  out_valid <= valid(10);
  out_friction <= friction_10;

end architecture rtl;
