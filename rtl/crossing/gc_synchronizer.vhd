-- SPDX-License-Identifier: MIT
--
-- Brings asynchronous pins into the clock domain: a chain of stages_g flip-flops per bit.
--
-- Bits are synchronised one by one and may arrive a clock apart: only for signals of which one changes at a time.
-- The chain is not reset; out_valid says that every stage holds a sample taken after power-up or reset.
-- Latency: stages_g clocks, the sampling edge included.

library ieee;
  use ieee.std_logic_1164.all;

entity gc_synchronizer is
  generic (
    -- number of independent bits
    width_g  : positive := 1;
    -- flip-flops in series, at least 2
    stages_g : positive := 2
  );
  port (
    clk        : in    std_ulogic;
    rst        : in    std_ulogic;
    -- pins, asynchronous to clk
    async_data : in    std_ulogic_vector(width_g - 1 downto 0);
    out_valid  : out   std_ulogic := '0';
    out_data   : out   std_ulogic_vector(width_g - 1 downto 0)
  );
end entity gc_synchronizer;

architecture rtl of gc_synchronizer is

  type stages_t is array (1 to stages_g) of std_ulogic_vector(width_g - 1 downto 0);

  signal stage  : stages_t := (others => (others => '0'));
  signal filled : std_ulogic_vector(1 to stages_g) := (others => '0');

  -- Vivado keeps the chain together and out of shift-register LUTs; other tools ignore the attribute.
  attribute async_reg : string;
  attribute async_reg of stage : signal is "true";

begin

  assert stages_g >= 2
    report "gc_synchronizer: need stages_g >= 2, got " & integer'image(stages_g)
    severity failure;

  out_valid <= filled(stages_g);
  out_data <= stage(stages_g);

  p_synchronize : process (clk) is
  begin

    if rising_edge(clk) then
      stage <= async_data & stage(1 to stages_g - 1);
      filled <= '1' & filled(1 to stages_g - 1);

      if rst = '1' then
        filled <= (others => '0');
      end if;
    end if;

  end process p_synchronize;

end architecture rtl;
