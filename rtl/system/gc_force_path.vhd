-- SPDX-License-Identifier: MIT
--
-- Encoder pins in, force and current commands out: one decoder per axis, the network, the compensator, currents
-- i = f / K_t. The network is gc_core or, with a ROM of the form serial, gc_core_serial. Behind it axes share
-- multipliers and tables, in turn, as far as the clocks between two results allow: all of them with one lane and in the
-- form serial, none where there is a result per clock (turns_of in gc_fixed_pkg).
--
-- Latency from accepted in_valid to out_valid: those of gc_core, gc_compensator and gc_current_scaler and 1 clock.
-- From a pin to the count: see gc_quad_decoder. Overflow and illegal input: see the status ports; none is silent.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_fixed_pkg.all;
  use work.gc_image_pkg.all;
  use work.gc_network_pkg.all;
  use work.gc_scalars_pkg.all;

entity gc_force_path is
  generic (
    -- Neurons per clock.
    lanes_g           : positive := 4;
    -- Clocks that an encoder level must last, 0 = no filter.
    filter_samples_g  : natural := 4;
    -- Clocks without an edge that count as standstill.
    speed_timeout_g   : positive := 10_000_000;
    -- What the axes cannot do, and what they may do for ever, clocks: see gc_edge_watch.
    reversal_clocks_g : positive := 250;
    dither_clocks_g   : positive := 40;
    -- Whether all constants can be replaced at run time; see gc_loader and gc_bank_switch.
    loadable_g        : boolean := false;
    -- Whether friction and cogging are added to the forces; else there is no compensator, for small parts.
    compensated_g     : boolean := true
  );
  port (
    clk                : in    std_ulogic;
    -- Synchronous, active high.
    rst                : in    std_ulogic;
    -- Encoder pins, asynchronous, axis 1 lowest.
    pin_a              : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_b              : in    std_ulogic_vector(axes_c - 1 downto 0);
    pin_z              : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Error outputs of fail-safe receivers: '1' means that the axis' other pins cannot be trusted.
    pin_error          : in    std_ulogic_vector(axes_c - 1 downto 0) := (others => '0');
    -- A rising edge begins homing of the axis, '0' ends it.
    cfg_home_enable    : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Count at the index, encoder counts, axis 1 lowest.
    cfg_index_position : in    signed(axes_c * count_bits_c - 1 downto 0);
    -- Counts from index to index, 0 = there is one, axis 1 lowest.
    cfg_index_period   : in    unsigned(axes_c * count_bits_c - 1 downto 0) := (others => '0');
    -- Clears the encoder flags.
    cfg_clear          : in    std_ulogic;
    -- Start of an inference on the counts of this clock, taken in a clock with in_ready.
    in_valid           : in    std_ulogic;
    in_ready           : out   std_ulogic;
    -- One clock per result; forces in mN and currents in uA hold until the next, axis 1 lowest.
    out_valid          : out   std_ulogic;
    out_force          : out   signed(axes_c * force_bits_c - 1 downto 0);
    out_current        : out   signed(axes_c * current_bits_c - 1 downto 0);
    -- Count was outside the trained range, output saturated: with out_valid, held likewise.
    out_clamped        : out   std_ulogic_vector(axes_c - 1 downto 0);
    out_saturated      : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Encoder counts, axis 1 lowest.
    sts_count          : out   signed(axes_c * count_bits_c - 1 downto 0);
    -- Direction of the last count, '1' = up.
    sts_direction      : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Clocks per 4 counts, negative when counting down, axis 1 lowest; see gc_speed_meter.
    sts_speed_period   : out   signed(axes_c * 32 - 1 downto 0);
    sts_speed_valid    : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_speed_zero     : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Count refers to the index.
    sts_referenced     : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- Counts were lost or cannot be trusted; a pulse was dropped: since the last cfg_clear.
    sts_illegal        : out   std_ulogic_vector(axes_c - 1 downto 0);
    sts_glitch         : out   std_ulogic_vector(axes_c - 1 downto 0);
    -- An image begins, in the bank that is not in use; a swap that waits is dropped.
    load_begin         : in    std_ulogic := '0';
    -- Its words, in order.
    load_valid         : in    std_ulogic := '0';
    load_word          : in    std_ulogic_vector(31 downto 0) := (others => '0');
    -- The image is whole: swap it in between two inferences if its length and CRC-32 are right.
    load_commit        : in    std_ulogic := '0';
    load_crc           : in    std_ulogic_vector(31 downto 0) := (others => '0');
    -- Back to the ROM, between two inferences.
    load_rom           : in    std_ulogic := '0';
    -- The last commit was refused; until the next load_begin.
    sts_load_bad       : out   std_ulogic;
    -- A swap waits for the inferences under way.
    sts_load_waiting   : out   std_ulogic;
    -- In use: "00" the ROM, "01" and "10" the banks.
    sts_bank           : out   std_ulogic_vector(1 downto 0);
    -- CRC-32 of the image in use, 0 with the ROM.
    sts_bank_crc       : out   std_ulogic_vector(31 downto 0)
  );
end entity gc_force_path;

architecture rtl of gc_force_path is

  -- Clocks between two results, at least; in the form serial each product of the output layer takes one.

  function result_interval return positive is
  begin

    if serial_form_c then
      return hidden_c * outputs_c;
    end if;

    return lane_steps(hidden_c, lanes_g);

  end function result_interval;

  constant turns_c          : positive := turns_of(axes_c, result_interval);
  constant scaler_latency_c : positive := current_scaler_latency(turns_c);

  signal count         : signed(axes_c * count_bits_c - 1 downto 0);
  signal count_valid   : std_ulogic_vector(axes_c - 1 downto 0);
  signal counts_valid  : std_ulogic;
  signal start         : std_ulogic;
  signal core_ready    : std_ulogic;
  signal core_valid    : std_ulogic;
  signal period        : signed(axes_c * 32 - 1 downto 0);
  signal network_mn    : signed(axes_c * force_bits_c - 1 downto 0);
  signal force_mn      : signed(axes_c * force_bits_c - 1 downto 0);
  signal clamped       : std_ulogic_vector(axes_c - 1 downto 0);
  signal saturated     : std_ulogic_vector(axes_c - 1 downto 0);
  -- Flags of the core, to wait for the compensator.
  signal flags         : std_ulogic_vector(axes_c + axes_c - 1 downto 0);
  signal flags_waited  : std_ulogic_vector(axes_c + axes_c - 1 downto 0);
  signal force_valid   : std_ulogic;
  signal unfit         : std_ulogic_vector(axes_c - 1 downto 0);
  -- Results: as they come, as the current scaler takes their forces, and as they have waited for it.
  signal result        : std_ulogic_vector(force_mn'length + axes_c + axes_c - 1 downto 0);
  signal held          : std_ulogic_vector(force_mn'length + axes_c + axes_c - 1 downto 0);
  signal scaled_mn     : signed(axes_c * force_bits_c - 1 downto 0);
  signal result_waited : std_ulogic_vector(force_mn'length + axes_c + axes_c - 1 downto 0);
  signal current       : signed(axes_c * current_bits_c - 1 downto 0);
  signal current_valid : std_ulogic;
  signal unfit_current : std_ulogic_vector(axes_c - 1 downto 0);
  signal valid         : std_ulogic := '0';
  -- Constants in use; while a swap of them waits no inference begins, after it the core is reset.
  signal memory        : memory_t := rom_memory_c;
  signal scalars       : scalars_t := rom_scalars_c;
  signal hold          : std_ulogic;
  signal restart       : std_ulogic;
  signal core_rst      : std_ulogic;

begin

  assert not (serial_form_c and loadable_g)
    report "gc_force_path: need loadable_g = false with a ROM of the form serial, got true"
    severity failure;

  g_decoder : for i in 0 to axes_c - 1 generate

    i_decoder : entity work.gc_quad_decoder
      generic map (
        filter_samples_g  => filter_samples_g,
        speed_timeout_g   => speed_timeout_g,
        reversal_clocks_g => reversal_clocks_g,
        dither_clocks_g   => dither_clocks_g
      )
      port map (
        clk                => clk,
        rst                => rst,
        a                  => pin_a(i),
        b                  => pin_b(i),
        z                  => pin_z(i),
        error              => pin_error(i),
        cfg_home_enable    => cfg_home_enable(i),
        cfg_index_position => cfg_index_position((i + 1) * count_bits_c - 1 downto i * count_bits_c),
        cfg_index_period   => cfg_index_period((i + 1) * count_bits_c - 1 downto i * count_bits_c),
        cfg_clear          => cfg_clear,
        count_valid        => count_valid(i),
        count              => count((i + 1) * count_bits_c - 1 downto i * count_bits_c),
        direction          => sts_direction(i),
        speed_valid        => sts_speed_valid(i),
        speed_zero         => sts_speed_zero(i),
        speed_period       => period((i + 1) * 32 - 1 downto i * 32),
        sts_referenced     => sts_referenced(i),
        sts_illegal        => sts_illegal(i),
        sts_glitch         => sts_glitch(i)
      );

  end generate g_decoder;

  p_counts_valid : process (all) is

    variable all_v : std_ulogic;

  begin

    all_v := '1';

    for i in count_valid'range loop

      all_v := all_v and count_valid(i);

    end loop;

    counts_valid <= all_v;

  end process p_counts_valid;

  start <= in_valid and counts_valid and not hold;
  in_ready <= core_ready and counts_valid and not hold;
  core_rst <= rst or restart;

  g_form : if serial_form_c generate

    i_core : entity work.gc_core_serial
      port map (
        clk           => clk,
        rst           => core_rst,
        in_valid      => start,
        in_ready      => core_ready,
        in_count      => count,
        out_valid     => core_valid,
        out_force     => network_mn,
        out_clamped   => clamped,
        out_saturated => saturated
      );

  else generate

    i_core : entity work.gc_core
      generic map (
        lanes_g    => lanes_g,
        loadable_g => loadable_g
      )
      port map (
        clk           => clk,
        rst           => core_rst,
        in_valid      => start,
        in_ready      => core_ready,
        in_count      => count,
        out_valid     => core_valid,
        out_force     => network_mn,
        out_clamped   => clamped,
        out_saturated => saturated,
        memory        => memory,
        scalars       => scalars
      );

  end generate g_form;

  flags <= clamped & saturated;

  g_compensator : if compensated_g generate

    i_flags : entity work.gc_delay
      generic map (
        bits_g   => flags'length,
        clocks_g => compensator_latency(turns_c)
      )
      port map (
        clk      => clk,
        in_data  => flags,
        out_data => flags_waited
      );

    i_compensator : entity work.gc_compensator
      generic map (
        turns_g    => turns_c,
        loadable_g => loadable_g
      )
      port map (
        clk           => clk,
        rst           => rst,
        in_valid      => core_valid,
        in_force      => network_mn,
        in_count      => count,
        in_period     => period,
        out_valid     => force_valid,
        out_force     => force_mn,
        out_saturated => unfit,
        memory        => memory,
        scalars       => scalars
      );

  else generate
    flags_waited <= flags;
    force_valid <= core_valid;
    force_mn <= network_mn;
    unfit <= (others => '0');
  end generate g_compensator;

  result <= std_ulogic_vector(force_mn) & flags_waited(flags_waited'high downto axes_c)
            & (flags_waited(axes_c - 1 downto 0) or unfit);

  -- What waits for currents that are made in turn, until the next result.

  g_held : if turns_c > 1 generate

    p_held : process (clk) is
    begin

      if rising_edge(clk) then
        if force_valid = '1' then
          held <= result;
        end if;
      end if;

    end process p_held;

  end generate g_held;

  -- The first axis of a multiplier goes in as it comes, the others from where they wait.

  g_scaled : for i in 0 to axes_c - 1 generate
    constant low_c  : natural := i * force_bits_c;
    constant high_c : natural := low_c + force_bits_c - 1;
  begin

    g_first : if i mod turns_c = 0 generate
      scaled_mn(high_c downto low_c) <= force_mn(high_c downto low_c);
    else generate
      scaled_mn(high_c downto low_c) <= signed(held(axes_c + axes_c + high_c downto axes_c + axes_c + low_c));
    end generate g_first;

  end generate g_scaled;

  i_current : entity work.gc_current_scaler
    generic map (
      turns_g => turns_c
    )
    port map (
      clk           => clk,
      rst           => rst,
      in_valid      => force_valid,
      in_force      => scaled_mn,
      out_valid     => current_valid,
      out_current   => current,
      out_saturated => unfit_current,
      scalars       => scalars
    );

  -- What still waits there when the currents come need not wait elsewhere.

  g_result : if turns_c > 1 and result_interval >= scaler_latency_c generate
    result_waited <= held;
  else generate

    i_result : entity work.gc_delay
      generic map (
        bits_g   => result'length,
        clocks_g => scaler_latency_c
      )
      port map (
        clk      => clk,
        in_data  => result,
        out_data => result_waited
      );

  end generate g_result;

  -- Commands hold between results: a drive never sees what is under way.
  p_hold : process (clk) is
  begin

    if rising_edge(clk) then
      valid <= current_valid;
      if current_valid = '1' then
        out_current <= current;
        out_force <= signed(result_waited(result_waited'high downto axes_c + axes_c));
        out_clamped <= result_waited(axes_c + axes_c - 1 downto axes_c);
        out_saturated <= result_waited(axes_c - 1 downto 0) or unfit_current;
      end if;
      if rst = '1' then
        valid <= '0';
        out_current <= (others => '0');
        out_force <= (others => '0');
        out_clamped <= (others => '0');
        out_saturated <= (others => '0');
      end if;
    end if;

  end process p_hold;

  g_load : if loadable_g generate
    signal accept         : std_ulogic;
    signal bank           : std_ulogic_vector(1 downto 0);
    signal loaded_bank    : std_ulogic_vector(1 downto 0);
    signal loaded_scalars : scalars_t;
    signal loaded_crc     : std_ulogic_vector(31 downto 0);
    signal accepted       : std_ulogic;
  begin

    i_loader : entity work.gc_loader
      port map (
        clk         => clk,
        rst         => rst,
        load_begin  => load_begin,
        load_valid  => load_valid,
        load_word   => load_word,
        load_commit => load_commit,
        load_crc    => load_crc,
        in_bank     => bank,
        memory      => memory,
        out_accept  => accept,
        out_bank    => loaded_bank,
        out_scalars => loaded_scalars,
        out_crc     => loaded_crc,
        sts_bad     => sts_load_bad
      );

    accepted <= start and core_ready;

    i_bank_switch : entity work.gc_bank_switch
      port map (
        clk         => clk,
        rst         => rst,
        in_accept   => accept,
        in_bank     => loaded_bank,
        in_scalars  => loaded_scalars,
        in_crc      => loaded_crc,
        load_rom    => load_rom,
        load_begin  => load_begin,
        in_start    => accepted,
        in_done     => current_valid,
        out_hold    => hold,
        out_restart => restart,
        out_bank    => bank,
        out_scalars => scalars,
        sts_waiting => sts_load_waiting,
        sts_crc     => sts_bank_crc
      );

    sts_bank <= bank;
  else generate
    signal bad : std_ulogic := '0';
  begin

    -- Every commit is refused.
    p_refuse : process (clk) is
    begin

      if rising_edge(clk) then
        if load_commit = '1' then
          bad <= '1';
        end if;
        if load_begin = '1' or rst = '1' then
          bad <= '0';
        end if;
      end if;

    end process p_refuse;

    memory <= rom_memory_c;
    scalars <= rom_scalars_c;
    hold <= '0';
    restart <= '0';
    sts_load_bad <= bad;
    sts_load_waiting <= '0';
    sts_bank <= "00";
    sts_bank_crc <= (others => '0');
  end generate g_load;

  out_valid <= valid;
  sts_count <= count;

  sts_speed_period <= period;

end architecture rtl;
