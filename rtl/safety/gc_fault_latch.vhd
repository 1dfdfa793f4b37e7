-- SPDX-License-Identifier: MIT
--
-- Remembers every cause of a fault until it is cleared, and the causes and the positions of the first one.
--
-- Causes that come in the same clock are first together: first_cause may have several bits. It is kept, even if it was
-- cleared, until no cause is left; the next one is first again.
-- A cause that is cleared while it lasts, or in the clock in which it comes, is kept. events counts the clocks that
-- bring a cause which is not there, modulo 256: one that comes, is cleared and comes again is not overlooked.
-- guard_g: upset = '1' one clock after a bit of what is remembered is not the one that was (gc_parity_guard).
-- Latency: 1 clock. first_count holds its value until the next first cause.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

entity gc_fault_latch is
  generic (
    -- Whether what is remembered is watched for wrong bits.
    guard_g : boolean := false
  );
  port (
    clk         : in    std_ulogic;
    -- Synchronous, active high; forgets all causes.
    rst         : in    std_ulogic;
    -- Causes to forget.
    in_clear    : in    causes_t;
    -- Causes of this clock.
    in_fault    : in    causes_t;
    -- Positions of this clock, encoder counts, axis 1 lowest.
    in_count    : in    signed(axes_c * count_bits_c - 1 downto 0);
    sts_fault   : out   causes_t := no_causes_c;
    first_cause : out   causes_t := no_causes_c;
    first_count : out   signed(axes_c * count_bits_c - 1 downto 0) := (others => '0');
    events      : out   unsigned(7 downto 0) := (others => '0');
    upset       : out   std_ulogic
  );
end entity gc_fault_latch;

architecture rtl of gc_fault_latch is

  signal left       : causes_t;
  signal next_first : causes_t;
  signal is_first   : std_ulogic;
  signal next_count : signed(axes_c * count_bits_c - 1 downto 0);

begin

  left <= (sts_fault and not in_clear) or in_fault when rst = '0' else no_causes_c;
  is_first <= '1' when sts_fault = no_causes_c and in_fault /= no_causes_c else '0';
  next_first <= no_causes_c when left = no_causes_c else
                in_fault when is_first = '1' else
                first_cause;
  next_count <= (others => '0') when rst = '1' else
                in_count when is_first = '1' else
                first_count;

  p_latch : process (clk) is
  begin

    if rising_edge(clk) then
      sts_fault <= left;
      first_cause <= next_first;
      first_count <= next_count;
      if (in_fault and not sts_fault) /= no_causes_c then
        events <= events + 1;
      end if;
      if rst = '1' then
        events <= (others => '0');
      end if;
    end if;

  end process p_latch;

  g_guard : if guard_g generate
    constant words_c  : positive := 1 + axes_c;
    constant bits_c   : positive := 2 * causes_c;
    signal   upsets   : std_ulogic_vector(words_c - 1 downto 0);
    signal   causes   : std_ulogic_vector(bits_c - 1 downto 0);
    signal   causes_1 : std_ulogic_vector(bits_c - 1 downto 0);
  begin

    causes <= next_first & left;
    causes_1 <= first_cause & sts_fault;

    i_causes : entity work.gc_parity_guard
      generic map (
        width_g => bits_c
      )
      port map (
        clk        => clk,
        rst        => rst,
        in_load    => '1',
        in_next    => causes,
        in_word    => causes_1,
        out_parity => open,
        out_upset  => upsets(0)
      );

    g_axis : for i in 0 to axes_c - 1 generate

      i_count : entity work.gc_parity_guard
        generic map (
          width_g => count_bits_c
        )
        port map (
          clk        => clk,
          rst        => rst,
          in_load    => '1',
          in_next    => std_ulogic_vector(next_count((i + 1) * count_bits_c - 1 downto i * count_bits_c)),
          in_word    => std_ulogic_vector(first_count((i + 1) * count_bits_c - 1 downto i * count_bits_c)),
          out_parity => open,
          out_upset  => upsets(1 + i)
        );

    end generate g_axis;

    upset <= '1' when unsigned(upsets) /= 0 else '0';
  else generate
    upset <= '0';
  end generate g_guard;

end architecture rtl;
