-- SPDX-License-Identifier: MIT
--
-- expired = '1' when the last cfg_clocks + 1 clocks were all without a restart; '0' after a restart or reset.
--
-- A limit of 0 expires in the first clock without a restart: no limit switches the time-out off.
-- Latency: 1 clock. Overflow: none, the count stops at the limit.
-- guard_g: upset = '1' one clock after the count is not the one that was counted (gc_parity_guard); costs nothing when
-- false, and upset is '0' then.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

entity gc_timeout is
  generic (
    -- Width of the limit.
    bits_g  : positive := 32;
    -- Whether the count is watched for wrong bits.
    guard_g : boolean := false
  );
  port (
    clk        : in    std_ulogic;
    -- Synchronous, active high.
    rst        : in    std_ulogic;
    restart    : in    std_ulogic;
    -- Limit, clocks; a change takes effect at once.
    cfg_clocks : in    unsigned(bits_g - 1 downto 0);
    expired    : out   std_ulogic := '0';
    upset      : out   std_ulogic
  );
end entity gc_timeout;

architecture rtl of gc_timeout is

  -- Clocks without a restart.
  signal quiet      : unsigned(bits_g - 1 downto 0) := (others => '0');
  signal next_quiet : unsigned(bits_g - 1 downto 0);
  signal is_short   : std_ulogic;

begin

  is_short <= '1' when quiet < cfg_clocks else '0';
  next_quiet <= (others => '0') when restart = '1' or rst = '1' else
                quiet + 1 when is_short = '1' else
                quiet;

  p_count : process (clk) is
  begin

    if rising_edge(clk) then
      quiet <= next_quiet;
      expired <= not (is_short or restart or rst);
    end if;

  end process p_count;

  g_guard : if guard_g generate

    i_guard : entity work.gc_parity_guard
      generic map (
        width_g => bits_g
      )
      port map (
        clk        => clk,
        rst        => rst,
        in_load    => '1',
        in_next    => std_ulogic_vector(next_quiet),
        in_word    => std_ulogic_vector(quiet),
        out_parity => open,
        out_upset  => upset
      );

  else generate
    upset <= '0';
  end generate g_guard;

end architecture rtl;
