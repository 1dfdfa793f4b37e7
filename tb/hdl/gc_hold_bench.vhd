-- SPDX-License-Identifier: MIT
--
-- One inference without Python: reports the forces that hold the robot at given encoder counts, and ends.
-- For simulators that FuseSoC starts. Fails when no result comes.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_hold_bench is
  generic (
    -- Neurons per clock.
    lanes_g : positive := 4;
    -- Encoder count of every axis.
    count_g : integer := 0
  );
end entity gc_hold_bench;

architecture sim of gc_hold_bench is

  signal clk       : std_ulogic := '0';
  signal rst       : std_ulogic := '1';
  signal done      : boolean := false;
  signal in_valid  : std_ulogic := '0';
  signal in_count  : signed(axes_c * count_bits_c - 1 downto 0);
  signal out_valid : std_ulogic;
  signal out_force : signed(axes_c * force_bits_c - 1 downto 0);

begin

  clk <= not clk after 5 ns when not done;

  -- The core of the ROM's form.

  g_serial : if serial_form_c generate

    i_core : entity work.gc_core_serial
      port map (
        clk           => clk,
        rst           => rst,
        in_valid      => in_valid,
        in_ready      => open,
        in_count      => in_count,
        out_valid     => out_valid,
        out_force     => out_force,
        out_clamped   => open,
        out_saturated => open
      );

  else generate

    i_core : entity work.gc_core
      generic map (
        lanes_g => lanes_g
      )
      port map (
        clk           => clk,
        rst           => rst,
        in_valid      => in_valid,
        in_ready      => open,
        in_count      => in_count,
        out_valid     => out_valid,
        out_force     => out_force,
        out_clamped   => open,
        out_saturated => open
      );

  end generate g_serial;

  g_count : for i in 0 to axes_c - 1 generate
    in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c) <= to_signed(count_g, count_bits_c);
  end generate g_count;

  p_infer : process is
  begin

    wait until falling_edge(clk);
    rst <= '0';
    wait until falling_edge(clk);
    in_valid <= '1';
    wait until falling_edge(clk);
    in_valid <= '0';
    wait until out_valid = '1' for 10 us;
    assert out_valid = '1'
      report "gc_hold_bench: no result"
      severity failure;
    wait until falling_edge(clk);
    assert not is_x(std_ulogic_vector(out_force))
      report "gc_hold_bench: a force is undefined"
      severity failure;

    for i in 0 to axes_c - 1 loop

      report "force " & integer'image(i + 1) & ": "
             & integer'image(to_integer(out_force((i + 1) * force_bits_c - 1 downto i * force_bits_c)))
             & " mN, of a rotary axis mNm";

    end loop;

    done <= true;
    wait;

  end process p_infer;

end architecture sim;
