-- SPDX-License-Identifier: MIT
--
-- Many inferences without Python: every force of gc_core against the one that a file says, to the bit.
-- A line of the file holds the encoder count of each axis, then the force of each axis in mN: `gravcomp vectors` writes
-- it from the bit-true model. Fails at a force that differs, at a result that does not come, and without a line.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library std;
  use std.textio.all;

library work;
  use work.gc_network_pkg.all;

entity gc_vectors_bench is
  generic (
    -- Neurons per clock.
    lanes_g   : positive := 4;
    -- Path of the file.
    vectors_g : string := "vectors.txt"
  );
end entity gc_vectors_bench;

architecture sim of gc_vectors_bench is

  -- Far longer than an inference with one lane.
  constant patience_c : time := 100 us;

  signal clk       : std_ulogic := '0';
  signal rst       : std_ulogic := '1';
  signal done      : boolean := false;
  signal in_valid  : std_ulogic := '0';
  signal in_ready  : std_ulogic;
  signal in_count  : signed(axes_c * count_bits_c - 1 downto 0) := (others => '0');
  signal out_valid : std_ulogic;
  signal out_force : signed(axes_c * force_bits_c - 1 downto 0);

  type integers_t is array (natural range <>) of integer;

  procedure read_vector (
    file source   : text;
    number        : natural;
    variable item : out integers_t
  ) is

    variable line_v : line;
    variable good_v : boolean;

  begin

    readline(source, line_v);

    for i in item'range loop

      read(line_v, item(i), good_v);
      assert good_v
        report "gc_vectors_bench: line " & integer'image(number) & ": need " & integer'image(item'length) & " integers"
        severity failure;

    end loop;

    deallocate(line_v);

  end procedure read_vector;

begin

  clk <= not clk after 5 ns when not done;

  -- The core of the ROM's form.

  g_serial : if serial_form_c generate

    i_core : entity work.gc_core_serial
      port map (
        clk           => clk,
        rst           => rst,
        in_valid      => in_valid,
        in_ready      => in_ready,
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
        in_ready      => in_ready,
        in_count      => in_count,
        out_valid     => out_valid,
        out_force     => out_force,
        out_clamped   => open,
        out_saturated => open
      );

  end generate g_serial;

  -- As fast as the core takes them.
  p_feed : process is

    file     source_v : text open read_mode is vectors_g;
    variable number_v : natural := 0;
    variable vector_v : integers_t(0 to axes_c + axes_c - 1);

  begin

    wait until falling_edge(clk);
    rst <= '0';

    while not endfile(source_v) loop

      number_v := number_v + 1;
      read_vector(source_v, number_v, vector_v);
      wait until falling_edge(clk);
      in_valid <= '1';

      for i in 0 to axes_c - 1 loop

        in_count((i + 1) * count_bits_c - 1 downto i * count_bits_c) <= to_signed(vector_v(i), count_bits_c);

      end loop;

      wait until rising_edge(clk) and in_ready = '1';

    end loop;

    wait until falling_edge(clk);
    in_valid <= '0';
    wait;

  end process p_feed;

  p_check : process is

    file     source_v : text open read_mode is vectors_g;
    variable number_v : natural := 0;
    variable vector_v : integers_t(0 to axes_c + axes_c - 1);
    variable force_v  : integer;

  begin

    while not endfile(source_v) loop

      number_v := number_v + 1;
      read_vector(source_v, number_v, vector_v);
      wait until rising_edge(clk) and out_valid = '1' for patience_c;
      assert out_valid = '1'
        report "gc_vectors_bench: line " & integer'image(number_v) & ": no result"
        severity failure;
      assert not is_x(std_ulogic_vector(out_force))
        report "gc_vectors_bench: line " & integer'image(number_v) & ": a force is undefined"
        severity failure;

      for i in 0 to axes_c - 1 loop

        force_v := to_integer(out_force((i + 1) * force_bits_c - 1 downto i * force_bits_c));
        assert force_v = vector_v(axes_c + i)
          report "gc_vectors_bench: line " & integer'image(number_v) & ": axis " & integer'image(i + 1) & ": "
                 & integer'image(force_v) & " mN, not " & integer'image(vector_v(axes_c + i))
          severity failure;

      end loop;

    end loop;

    assert number_v > 0
      report "gc_vectors_bench: no line in " & vectors_g
      severity failure;
    report "gc_vectors_bench: " & integer'image(number_v) & " lines, every force equal";
    done <= true;
    wait;

  end process p_check;

end architecture sim;
