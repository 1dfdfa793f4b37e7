-- SPDX-License-Identifier: MIT
--
-- Remembers every cause of a fault until it is cleared, and the causes and the positions of the first one.
--
-- Causes that come in the same clock are first together: first_cause may have several bits. It is kept, even if it was
-- cleared, until no cause is left; the next one is first again.
-- A cause that is cleared while it lasts, or in the clock in which it comes, is kept. events counts the clocks that
-- bring a cause which is not there, modulo 256: one that comes, is cleared and comes again is not overlooked.
-- Latency: 1 clock. first_count holds its value until the next first cause.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;
  use work.gc_safety_pkg.all;

entity gc_fault_latch is
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; forgets all causes.
    rst         : in    std_ulogic;
    -- Causes to forget.
    in_clear    : in    causes_t;
    -- Causes of this clock.
    in_fault    : in    causes_t;
    -- Positions of this clock, encoder counts, axis 1 lowest.
    in_count    : in    signed(inputs_c * count_bits_c - 1 downto 0);
    sts_fault   : out   causes_t := no_causes_c;
    first_cause : out   causes_t := no_causes_c;
    first_count : out   signed(inputs_c * count_bits_c - 1 downto 0) := (others => '0');
    events      : out   unsigned(7 downto 0) := (others => '0')
  );
end entity gc_fault_latch;

architecture rtl of gc_fault_latch is

begin

  p_latch : process (clk) is

    variable left_v : causes_t;

  begin

    if rising_edge(clk) then
      left_v := (sts_fault and not in_clear) or in_fault;
      sts_fault <= left_v;

      if (left_v and not sts_fault) /= no_causes_c then
        events <= events + 1;
      end if;

      if left_v = no_causes_c then
        first_cause <= no_causes_c;
      elsif sts_fault = no_causes_c then
        first_cause <= in_fault;
        first_count <= in_count;
      end if;

      if rst = '1' then
        sts_fault <= no_causes_c;
        first_cause <= no_causes_c;
        first_count <= (others => '0');
        events <= (others => '0');
      end if;
    end if;

  end process p_latch;

end architecture rtl;
