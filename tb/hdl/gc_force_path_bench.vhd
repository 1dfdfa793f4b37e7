-- SPDX-License-Identifier: MIT
--
-- gc_force_path with an encoder model on the pins of each axis: the test moves the axes, the bench makes the edges.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_force_path_bench is
  generic (
    lanes_g       : positive := 4;
    loadable_g    : boolean := false;
    compensated_g : boolean := true
  );
  port (
    clk              : in    std_ulogic;
    rst              : in    std_ulogic;
    -- Position of each axis to walk to and of its index, counts, axis 1 lowest; see gc_encoder_model.
    target           : in    signed(axes_c * 32 - 1 downto 0);
    index_count      : in    signed(axes_c * 32 - 1 downto 0);
    load             : in    std_ulogic;
    clocks_per_edge  : in    unsigned(15 downto 0);
    busy             : out   std_ulogic_vector(axes_c - 1 downto 0);
    home_enable      : in    std_ulogic;
    in_valid         : in    std_ulogic;
    in_ready         : out   std_ulogic;
    out_valid        : out   std_ulogic;
    out_force        : out   signed(axes_c * force_bits_c - 1 downto 0);
    out_current      : out   signed(axes_c * current_bits_c - 1 downto 0);
    out_clamped      : out   std_ulogic_vector(axes_c - 1 downto 0);
    out_saturated    : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_count        : out   signed(axes_c * count_bits_c - 1 downto 0);
    sts_speed_period : out   signed(axes_c * 32 - 1 downto 0);
    sts_referenced   : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_illegal      : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_glitch       : out   std_ulogic_vector(axes_c - 1 downto 0);
    load_begin       : in    std_ulogic := '0';
    load_valid       : in    std_ulogic := '0';
    load_word        : in    std_ulogic_vector(31 downto 0) := (others => '0');
    load_commit      : in    std_ulogic := '0';
    load_crc         : in    std_ulogic_vector(31 downto 0) := (others => '0');
    load_rom         : in    std_ulogic := '0';
    sts_load_bad     : out   std_ulogic;
    sts_load_waiting : out   std_ulogic;
    sts_bank         : out   std_ulogic_vector(1 downto 0);
    sts_bank_crc     : out   std_ulogic_vector(31 downto 0)
  );
end entity gc_force_path_bench;

architecture sim of gc_force_path_bench is

  signal a          : std_ulogic_vector(axes_c - 1 downto 0);
  signal b          : std_ulogic_vector(axes_c - 1 downto 0);
  signal z          : std_ulogic_vector(axes_c - 1 downto 0);
  signal true_count : signed(axes_c * 32 - 1 downto 0);

begin

  g_encoder : for i in 0 to axes_c - 1 generate

    i_encoder : entity work.gc_encoder_model
      port map (
        clk             => clk,
        target          => target((i + 1) * 32 - 1 downto i * 32),
        clocks_per_edge => clocks_per_edge,
        load            => load,
        load_count      => index_count((i + 1) * 32 - 1 downto i * 32),
        index_count     => index_count((i + 1) * 32 - 1 downto i * 32),
        a               => a(i),
        b               => b(i),
        z               => z(i),
        count           => true_count((i + 1) * 32 - 1 downto i * 32),
        busy            => busy(i)
      );

  end generate g_encoder;

  i_force_path : entity work.gc_force_path
    generic map (
      lanes_g       => lanes_g,
      loadable_g    => loadable_g,
      compensated_g => compensated_g
    )
    port map (
      clk                => clk,
      rst                => rst,
      pin_a              => a,
      pin_b              => b,
      pin_z              => z,
      cfg_home_enable    => (others => home_enable),
      cfg_index_position => index_count,
      cfg_clear          => '0',
      in_valid           => in_valid,
      in_ready           => in_ready,
      out_valid          => out_valid,
      out_force          => out_force,
      out_current        => out_current,
      out_clamped        => out_clamped,
      out_saturated      => out_saturated,
      sts_count          => sts_count,
      sts_direction      => open,
      sts_speed_period   => sts_speed_period,
      sts_speed_valid    => open,
      sts_speed_zero     => open,
      sts_referenced     => sts_referenced,
      sts_illegal        => sts_illegal,
      sts_glitch         => sts_glitch,
      load_begin         => load_begin,
      load_valid         => load_valid,
      load_word          => load_word,
      load_commit        => load_commit,
      load_crc           => load_crc,
      load_rom           => load_rom,
      sts_load_bad       => sts_load_bad,
      sts_load_waiting   => sts_load_waiting,
      sts_bank           => sts_bank,
      sts_bank_crc       => sts_bank_crc
    );

end architecture sim;
