-- SPDX-License-Identifier: MIT
--
-- One clock of in_valid becomes one clock of out_valid in another, unrelated clock domain.
--
-- A pulse taken (in_valid and in_ready) inverts a level; the other side sees the level change and sends it back, upon
-- which in_ready rises again. No pulse is lost or doubled, whatever the two clocks; one offered without in_ready is not
-- taken. Not reset: a reset of one side alone would make or lose a pulse.
-- Latency: stages_g clocks of out_clk, or up to one more, from the edge that takes the pulse to the edge at whose end
-- out_valid has passed; from there as many clocks of in_clk to in_ready.
-- Timing: both levels end in a gc_synchronizer; a path between the clocks needs no other exception here.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_crossing_pulse is
  generic (
    -- Flip-flops against metastability in each direction, at least 2.
    stages_g : positive := 2
  );
  port (
    in_clk    : in    std_ulogic;
    in_valid  : in    std_ulogic;
    in_ready  : out   std_ulogic;
    out_clk   : in    std_ulogic;
    out_valid : out   std_ulogic
  );
end entity gc_crossing_pulse;

architecture rtl of gc_crossing_pulse is

  signal sent     : std_ulogic := '0';
  signal arriving : std_ulogic;
  signal arrived  : std_ulogic := '0';
  signal answer   : std_ulogic;

begin

  in_ready <= sent xnor answer;

  p_in : process (in_clk) is
  begin

    if rising_edge(in_clk) then
      if in_valid = '1' and sent = answer then
        sent <= not sent;
      end if;
    end if;

  end process p_in;

  i_there : entity work.gc_synchronizer
    generic map (
      stages_g => stages_g
    )
    port map (
      clk           => out_clk,
      rst           => '0',
      async_data(0) => sent,
      out_valid     => open,
      out_data(0)   => arriving
    );

  out_valid <= arriving xor arrived;

  p_out : process (out_clk) is
  begin

    if rising_edge(out_clk) then
      arrived <= arriving;
    end if;

  end process p_out;

  i_back : entity work.gc_synchronizer
    generic map (
      stages_g => stages_g
    )
    port map (
      clk           => in_clk,
      rst           => '0',
      async_data(0) => arrived,
      out_valid     => open,
      out_data(0)   => answer
    );

end architecture rtl;
