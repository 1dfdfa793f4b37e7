-- SPDX-License-Identifier: MIT
--
-- n values that come at once go out one after the other: the first in the clock in which they come, the others, which
-- wait here, in the clocks after it.
--
-- Latency: 0 clocks for value 0, k for value k; in_valid must stay values_g clocks apart.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_fixed_pkg.all;

entity gc_in_turn is
  generic (
    -- Number of values.
    values_g : positive := 3;
    -- Width of a value, bits.
    bits_g   : positive := 18
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; forgets the values that wait.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    -- Value 0 lowest.
    in_values : in    std_ulogic_vector(values_g * bits_g - 1 downto 0);
    out_valid : out   std_ulogic;
    -- Which value it is.
    out_turn  : out   unsigned(index_bits(values_g) - 1 downto 0);
    out_value : out   std_ulogic_vector(bits_g - 1 downto 0)
  );
end entity gc_in_turn;

architecture rtl of gc_in_turn is

begin

  g_one : if values_g = 1 generate
    out_valid <= in_valid;
    out_turn <= (others => '0');
    out_value <= in_values;
  end generate g_one;

  g_several : if values_g > 1 generate
    constant nothing_c : std_ulogic_vector(bits_g - 1 downto 0) := (others => '0');

    -- The one that goes out next, 0 if none waits.
    signal turn    : unsigned(out_turn'range) := (others => '0');
    signal waiting : std_ulogic_vector((values_g - 1) * bits_g - 1 downto 0);
  begin

    p_wait : process (clk) is

      variable shifted_v : std_ulogic_vector(values_g * bits_g - 1 downto 0);

    begin

      if rising_edge(clk) then
        shifted_v := nothing_c & waiting;
        waiting <= shifted_v(shifted_v'high downto bits_g);
        if turn /= 0 then
          turn <= turn + 1;
        end if;
        if turn = values_g - 1 then
          turn <= (others => '0');
        end if;
        if in_valid = '1' then
          waiting <= in_values(in_values'high downto bits_g);
          turn <= to_unsigned(1, turn'length);
        end if;
        if rst = '1' then
          turn <= (others => '0');
        end if;
      end if;

    end process p_wait;

    p_select : process (all) is
    begin

      out_valid <= in_valid;
      out_turn <= (others => '0');
      out_value <= in_values(bits_g - 1 downto 0);

      if in_valid = '0' then
        out_turn <= turn;
        out_value <= waiting(bits_g - 1 downto 0);
        if turn /= 0 then
          out_valid <= '1';
        end if;
      end if;

    end process p_select;

  end generate g_several;

end architecture rtl;
