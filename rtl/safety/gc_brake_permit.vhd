-- SPDX-License-Identifier: MIT
--
-- The second path to the brakes: the rules of gc_brake_sequencer once more, written as three flags and kept in
-- registers of their own, so that no single wrong bit opens a brake that needs both paths.
--
--   faulty   from a fault until all are cleared
--   idle     no motion: until a rising enable while healthy; again from a fault, or when the brakes have closed
--   shut     brakes engaged: until the motors carry the load and the brakes are tested; again from a low enable on
--
-- A brake is let go while all three are '0', or while its test asks for it and the command is active. Flags that
-- contradict each other lead to faulty. Inputs have the meaning of those of gc_brake_sequencer, which is in the same
-- clock where it agrees: state FAULT = faulty, run = not idle, RUN = not shut. gc_brakes compares them.
-- Latency: 1 clock. Reset: idle and shut, not faulty.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_network_pkg.all;

entity gc_brake_permit is
  generic (
    -- Whether the time-out is watched for wrong bits.
    guard_g : boolean := false
  );
  port (
    clk              : in    std_ulogic;
    -- Synchronous, active high.
    rst              : in    std_ulogic;
    enable           : in    std_ulogic;
    clear            : in    std_ulogic;
    in_fault         : in    std_ulogic;
    in_healthy       : in    std_ulogic;
    in_carried       : in    std_ulogic;
    -- The test of the brakes is over.
    in_tested        : in    std_ulogic;
    -- The test lets go the brake of the axis.
    in_test          : in    std_ulogic_vector(axes_c - 1 downto 0);
    cfg_brake_clocks : in    unsigned(31 downto 0);
    faulty           : out   std_ulogic := '0';
    idle             : out   std_ulogic := '1';
    shut             : out   std_ulogic := '1';
    -- '0' lets the brake of the axis go.
    brake_engage     : out   std_ulogic_vector(axes_c - 1 downto 0) := (others => '1');
    upset            : out   std_ulogic
  );
end entity gc_brake_permit;

architecture rtl of gc_brake_permit is

  -- '0' at power-up: a level of enable found then is no edge.
  signal was_low      : std_ulogic := '0';
  signal enable_moved : std_ulogic;
  signal unsettled    : std_ulogic;
  signal waited       : std_ulogic;
  signal may_change   : std_ulogic;

begin

  enable_moved <= enable xnor was_low;
  unsettled <= idle or faulty or not shut or enable_moved or (enable and not in_carried);

  i_wait : entity work.gc_timeout
    generic map (
      guard_g => guard_g
    )
    port map (
      clk        => clk,
      rst        => rst,
      restart    => unsettled,
      cfg_clocks => cfg_brake_clocks,
      expired    => waited,
      upset      => upset
    );

  may_change <= waited and not unsettled;

  p_flags : process (clk) is

    variable faulty_v : std_ulogic;
    variable idle_v   : std_ulogic;
    variable shut_v   : std_ulogic;

  begin

    if rising_edge(clk) then
      was_low <= not enable;
      faulty_v := faulty;
      idle_v := idle;
      shut_v := shut;

      if faulty = '1' then
        faulty_v := not clear;
      elsif idle = '1' then
        idle_v := not (enable and was_low and in_healthy);
      elsif shut = '0' then
        shut_v := not enable;
      elsif may_change = '1' then
        idle_v := not enable;
        shut_v := not (enable and in_tested);
      end if;

      if in_fault = '1' or (shut = '0' and idle = '1') or (idle = '0' and faulty = '1') then
        faulty_v := '1';
      end if;
      if faulty_v = '1' then
        idle_v := '1';
        shut_v := '1';
      end if;
      if rst = '1' then
        faulty_v := '0';
        idle_v := '1';
        shut_v := '1';
      end if;

      faulty <= faulty_v;
      idle <= idle_v;
      shut <= shut_v;

      for i in brake_engage'range loop

        brake_engage(i) <= idle_v or (shut_v and not in_test(i));

      end loop;

    end if;

  end process p_flags;

end architecture rtl;
