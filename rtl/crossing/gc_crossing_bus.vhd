-- SPDX-License-Identifier: MIT
--
-- Words into another, unrelated clock domain, whole: request and acknowledge with a held word.
--
-- A word taken (in_valid and in_ready) is held until the other side has it; every word taken arrives once. With
-- in_valid always high, out_data follows in_data as often as the round trip allows.
-- Latency: stages_g clocks of out_clk, or up to one more, from the edge that takes the word to the one that brings
-- out_valid and out_data; in_ready rises stages_g clocks of in_clk, or up to one more, after that.
-- Timing: `held` is stable for stages_g clocks of out_clk before it is taken, so its path to out_data needs a maximum
-- delay of that length and no other check.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_crossing_bus is
  generic (
    width_g  : positive := 32;
    -- Flip-flops against metastability in each direction, at least 2.
    stages_g : positive := 2
  );
  port (
    in_clk    : in    std_ulogic;
    in_valid  : in    std_ulogic;
    in_ready  : out   std_ulogic;
    in_data   : in    std_ulogic_vector(width_g - 1 downto 0);
    out_clk   : in    std_ulogic;
    -- Synchronous to out_clk, active high: out_data to zero. A word that arrives meanwhile is lost, no other is.
    out_rst   : in    std_ulogic;
    -- One clock per word; out_data hold until the next.
    out_valid : out   std_ulogic := '0';
    out_data  : out   std_ulogic_vector(width_g - 1 downto 0) := (others => '0')
  );
end entity gc_crossing_bus;

architecture rtl of gc_crossing_bus is

  signal ready   : std_ulogic;
  signal held    : std_ulogic_vector(width_g - 1 downto 0) := (others => '0');
  signal arrives : std_ulogic;

begin

  i_pulse : entity work.gc_crossing_pulse
    generic map (
      stages_g => stages_g
    )
    port map (
      in_clk    => in_clk,
      in_valid  => in_valid,
      in_ready  => ready,
      out_clk   => out_clk,
      out_valid => arrives
    );

  in_ready <= ready;

  p_hold : process (in_clk) is
  begin

    if rising_edge(in_clk) then
      if in_valid = '1' and ready = '1' then
        held <= in_data;
      end if;
    end if;

  end process p_hold;

  p_take : process (out_clk) is
  begin

    if rising_edge(out_clk) then
      out_valid <= arrives;
      if arrives = '1' then
        out_data <= held;
      end if;
      if out_rst = '1' then
        out_valid <= '0';
        out_data <= (others => '0');
      end if;
    end if;

  end process p_take;

end architecture rtl;
