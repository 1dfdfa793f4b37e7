-- SPDX-License-Identifier: MIT
--
-- Safety: states, causes of a fault, parity.

library ieee;
  use ieee.std_logic_1164.all;

package gc_safety_pkg is

  -- States; any two differ in two bits, so no single upset leads from one to another.

  subtype safety_state_t is std_ulogic_vector(2 downto 0);

  constant state_braked_c  : safety_state_t := "000";
  constant state_holding_c : safety_state_t := "011";
  constant state_run_c     : safety_state_t := "101";
  constant state_fault_c   : safety_state_t := "110";

  -- Causes, bit by bit; docs/guide/safety.md says when each is present.
  constant causes_c           : positive := 16;
  constant cause_estop_c      : natural  := 0;
  constant cause_encoder_c    : natural  := 1;
  constant cause_crc_c        : natural  := 2;
  constant cause_rom_c        : natural  := 3;
  constant cause_speed_c      : natural  := 4;
  constant cause_position_c   : natural  := 5;
  constant cause_saturation_c : natural  := 6;
  constant cause_watchdog_c   : natural  := 7;
  constant cause_result_c     : natural  := 8;
  constant cause_reference_c  : natural  := 9;
  constant cause_command_c    : natural  := 10;
  constant cause_hold_c       : natural  := 11;
  constant cause_brake_c      : natural  := 12;
  constant cause_clock_c      : natural  := 13;
  constant cause_core_c       : natural  := 14;
  constant cause_upset_c      : natural  := 15;

  subtype causes_t is std_ulogic_vector(causes_c - 1 downto 0);

  constant no_causes_c : causes_t := (others => '0');

  -- Causes that are faults while braked, too: what comes from outside, and what the core finds in itself. The others
  -- keep the brakes engaged then.
  constant outer_causes_c  : causes_t := (cause_rom_c downto cause_estop_c => '1', others => '0');
  constant inner_causes_c  : causes_t := (cause_brake_c | cause_core_c | cause_upset_c => '1', others => '0');
  constant always_causes_c : causes_t := outer_causes_c or inner_causes_c;

  -- XOR of all bits.

  function parity_of (
    word : std_ulogic_vector
  ) return std_ulogic;

end package gc_safety_pkg;

package body gc_safety_pkg is

  function parity_of (
    word : std_ulogic_vector
  ) return std_ulogic is

    variable parity_v : std_ulogic := '0';

  begin

    for i in word'range loop

      parity_v := parity_v xor word(i);

    end loop;

    return parity_v;

  end function parity_of;

end package body gc_safety_pkg;
