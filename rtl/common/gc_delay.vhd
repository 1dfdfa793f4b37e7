-- SPDX-License-Identifier: MIT
--
-- out_data = in_data, clocks_g clocks later: carries flags beside a pipeline. Latency: clocks_g clocks.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_delay is
  generic (
    -- Width, bits.
    bits_g   : positive := 1;
    -- Latency, clocks.
    clocks_g : positive := 1
  );
  port (
    clk      : in    std_ulogic;
    in_data  : in    std_ulogic_vector(bits_g - 1 downto 0);
    out_data : out   std_ulogic_vector(bits_g - 1 downto 0)
  );
end entity gc_delay;

architecture rtl of gc_delay is

  type stages_t is array (1 to clocks_g) of std_ulogic_vector(bits_g - 1 downto 0);

  signal stages : stages_t;

begin

  p_delay : process (clk) is
  begin

    if rising_edge(clk) then
      stages(1) <= in_data;

      for i in 2 to clocks_g loop

        stages(i) <= stages(i - 1);

      end loop;

    end if;

  end process p_delay;

  out_data <= stages(clocks_g);

end architecture rtl;
