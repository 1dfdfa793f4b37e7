-- SPDX-License-Identifier: MIT
--
-- out_data = in_data one clock later: a copy for one of several users of the same data, to stand near that user.
--
-- Synthesis must not merge the copies (keep; for Yosys by name, as GHDL passes no attributes on). Latency: 1 clock.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_copy is
  generic (
    -- Width, bits.
    bits_g : positive := 18
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

  signal valid : std_ulogic := '0';
  signal data  : signed(bits_g - 1 downto 0);

  attribute keep : string;
  attribute keep of valid : signal is "true";
  attribute keep of data  : signal is "true";

begin

  p_copy : process (clk) is
  begin

    if rising_edge(clk) then
      valid <= in_valid;
      data <= in_data;
      if rst = '1' then
        valid <= '0';
      end if;
    end if;

  end process p_copy;

  out_valid <= valid;
  out_data <= data;

end architecture rtl;
