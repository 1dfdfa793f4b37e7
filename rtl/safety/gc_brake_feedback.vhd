-- SPDX-License-Identifier: MIT
--
-- Compares what each brake was told with what its read-back pin says.
--
--   out_differs = '1' when the two were different, on one axis, in the last cfg_clocks + 1 clocks
--
-- in_released is delayed like the pins, so that a pin that follows at once never differs.
-- The input of an open pin must read '0': pull it down.
-- Latency: sync_stages_g + 1 clocks. After reset nothing differs until the pins are known.
-- guard_g: upset = '1' one clock after a wrong bit in a time-out. Of the other registers a wrong bit lasts one clock.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_brake_feedback is
  generic (
    -- Whether the time-outs are watched for wrong bits.
    guard_g       : boolean := false;
    -- Flip-flops of the pins against metastability, at least 2.
    sync_stages_g : positive := 2
  );
  port (
    clk          : in    std_ulogic;
    -- Synchronous, active high.
    rst          : in    std_ulogic;
    -- Read-back per axis, asynchronous; '1': the brake is fed, it is released.
    brake_fed    : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- The brake of the axis is told to open.
    in_released  : in    std_ulogic_vector(axes_c - 1 downto 0);
    -- Longest difference that is no fault, clocks.
    cfg_clocks   : in    unsigned(31 downto 0);
    -- The pins, synchronous.
    out_feedback : out   std_ulogic_vector(axes_c - 1 downto 0);
    out_differs  : out   std_ulogic;
    upset        : out   std_ulogic
  );
end entity gc_brake_feedback;

architecture rtl of gc_brake_feedback is

  signal known   : std_ulogic;
  signal level   : std_ulogic_vector(axes_c - 1 downto 0);
  signal told    : std_ulogic_vector(axes_c - 1 downto 0);
  signal agrees  : std_ulogic_vector(axes_c - 1 downto 0);
  signal differs : std_ulogic_vector(axes_c - 1 downto 0);
  signal upsets  : std_ulogic_vector(axes_c - 1 downto 0);

begin

  i_pins : entity work.gc_synchronizer
    generic map (
      width_g  => axes_c,
      stages_g => sync_stages_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      async_data => brake_fed,
      out_valid  => known,
      out_data   => level
    );

  i_told : entity work.gc_delay
    generic map (
      bits_g   => axes_c,
      clocks_g => sync_stages_g
    )
    port map (
      clk      => clk,
      in_data  => in_released,
      out_data => told
    );

  g_axis : for i in 0 to axes_c - 1 generate
    agrees(i) <= (level(i) xnor told(i)) or not known;

    i_time : entity work.gc_timeout
      generic map (
        guard_g => guard_g
      )
      port map (
        clk        => clk,
        rst        => rst,
        restart    => agrees(i),
        cfg_clocks => cfg_clocks,
        expired    => differs(i),
        upset      => upsets(i)
      );

  end generate g_axis;

  out_feedback <= level;
  out_differs <= '1' when unsigned(differs) /= 0 else '0';
  upset <= '1' when unsigned(upsets) /= 0 else '0';

end architecture rtl;
