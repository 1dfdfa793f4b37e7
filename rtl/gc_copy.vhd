-- SPDX-License-Identifier: MIT
--
-- out_data = in_data clocks_g clocks later: a copy for one of several users of the same data, to stand near that user,
-- with a register for each part of a long way there.
--
-- Synthesis must not merge the copies (keep; for Yosys by name, as GHDL passes no attributes on). Latency: clocks_g.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_copy is
  generic (
    -- Width, bits.
    bits_g   : positive := 18;
    -- Registers one behind the other.
    clocks_g : positive := 1
  );
  port (
    clk       : in    std_ulogic;
    -- Synchronous, active high; clears valid.
    rst       : in    std_ulogic;
    in_valid  : in    std_ulogic;
    in_data   : in    signed(bits_g - 1 downto 0);
    out_valid : out   std_ulogic;
    out_data  : out   signed(bits_g - 1 downto 0)
  );
end entity gc_copy;

architecture rtl of gc_copy is

  type copies_t is array (1 to clocks_g) of signed(bits_g - 1 downto 0);

  signal valid : std_ulogic_vector(1 to clocks_g) := (others => '0');
  signal data  : copies_t;

  attribute keep : string;
  attribute keep of valid : signal is "true";
  attribute keep of data  : signal is "true";

begin

  p_copy : process (clk) is
  begin

    if rising_edge(clk) then
      valid(1) <= in_valid;
      data(1) <= in_data;

      for k in 2 to clocks_g loop

        valid(k) <= valid(k - 1);
        data(k) <= data(k - 1);

      end loop;

      if rst = '1' then
        valid <= (others => '0');
      end if;
    end if;

  end process p_copy;

  out_valid <= valid(clocks_g);
  out_data <= data(clocks_g);

end architecture rtl;
