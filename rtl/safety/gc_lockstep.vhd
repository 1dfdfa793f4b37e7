-- SPDX-License-Identifier: MIT
--
-- Compares what two copies of a circuit put out, the second of which lives lag_g clocks behind the first.
--
--   out_differ(t) = '1' when in_twin(t - 1) /= in_main(t - 1 - lag_g)
--
-- The lag keeps synthesis from merging the copies, and what disturbs both at once from doing the same to both.
-- Latency: 1 clock. In the lag_g clocks after power-up in_twin is compared with zeros.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_lockstep is
  generic (
    -- Width of what is compared, bits.
    bits_g : positive := 1;
    -- Clocks that the second copy is behind.
    lag_g  : positive := 1
  );
  port (
    clk        : in    std_ulogic;
    -- Synchronous, active high: no difference.
    rst        : in    std_ulogic;
    in_main    : in    std_ulogic_vector(bits_g - 1 downto 0);
    in_twin    : in    std_ulogic_vector(bits_g - 1 downto 0);
    out_differ : out   std_ulogic := '0'
  );
end entity gc_lockstep;

architecture rtl of gc_lockstep is

  type stages_t is array (1 to lag_g) of std_ulogic_vector(bits_g - 1 downto 0);

  signal main : stages_t := (others => (others => '0'));

begin

  p_compare : process (clk) is
  begin

    if rising_edge(clk) then
      main(1) <= in_main;

      for i in 2 to lag_g loop

        main(i) <= main(i - 1);

      end loop;

      out_differ <= '0';
      if in_twin /= main(lag_g) then
        out_differ <= '1';
      end if;
      if rst = '1' then
        out_differ <= '0';
      end if;
    end if;

  end process p_compare;

end architecture rtl;
