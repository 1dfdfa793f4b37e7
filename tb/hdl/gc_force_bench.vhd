-- SPDX-License-Identifier: MIT
--
-- gc_core and gc_compensator on given counts and speeds, without encoders: measured samples, one after the other.
--
-- Count and period wait beside the core, so that each force meets those of its own sample.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_force_bench is
  generic (
    lanes_g : positive := 4
  );
  port (
    clk           : in    std_ulogic;
    rst           : in    std_ulogic;
    in_valid      : in    std_ulogic;
    in_ready      : out   std_ulogic;
    -- Encoder counts, and clocks per 4 counts as of gc_speed_meter, axis 1 lowest.
    in_count      : in    signed(axes_c * count_bits_c - 1 downto 0);
    in_period     : in    signed(axes_c * 32 - 1 downto 0);
    out_valid     : out   std_ulogic;
    out_force     : out   signed(axes_c * force_bits_c - 1 downto 0);
    out_saturated : out   std_ulogic_vector(axes_c - 1 downto 0)
  );
end entity gc_force_bench;

architecture sim of gc_force_bench is

  signal core_valid : std_ulogic;
  signal core_force : signed(axes_c * force_bits_c - 1 downto 0);
  signal clamped    : std_ulogic_vector(axes_c - 1 downto 0);
  signal saturated  : std_ulogic_vector(axes_c - 1 downto 0);
  signal sample     : std_ulogic_vector(in_count'length + in_period'length - 1 downto 0);
  signal waited     : std_ulogic_vector(in_count'length + in_period'length - 1 downto 0);

begin

  i_core : entity work.gc_core
    generic map (
      lanes_g => lanes_g
    )
    port map (
      clk           => clk,
      rst           => rst,
      in_valid      => in_valid,
      in_ready      => in_ready,
      in_count      => in_count,
      out_valid     => core_valid,
      out_force     => core_force,
      out_clamped   => clamped,
      out_saturated => saturated
    );

  sample <= std_ulogic_vector(in_count) & std_ulogic_vector(in_period);

  -- A queue in a variable: a shift register as wide as this would take most of the simulator's time.
  p_wait : process (clk) is

    -- More than are under way in any core.
    constant places_c : positive := 64;

    type queue_t is array (0 to places_c - 1) of std_ulogic_vector(sample'range);

    variable queue_v : queue_t;
    variable first_v : natural range 0 to places_c - 1 := 0;
    variable free_v  : natural range 0 to places_c - 1 := 0;

  begin

    if rising_edge(clk) then
      if in_valid = '1' and in_ready = '1' then
        queue_v(free_v) := sample;
        free_v          := (free_v + 1) mod places_c;
      end if;
      if core_valid = '1' then
        first_v := (first_v + 1) mod places_c;
      end if;
      waited <= queue_v(first_v);
    end if;

  end process p_wait;

  i_compensator : entity work.gc_compensator
    port map (
      clk           => clk,
      rst           => rst,
      in_valid      => core_valid,
      in_force      => core_force,
      in_count      => signed(waited(waited'high downto in_period'length)),
      in_period     => signed(waited(in_period'length - 1 downto 0)),
      out_valid     => out_valid,
      out_force     => out_force,
      out_saturated => out_saturated
    );

end architecture sim;
