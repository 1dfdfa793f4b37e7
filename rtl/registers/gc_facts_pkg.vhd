-- SPDX-License-Identifier: MIT
--
-- Written by `make regs` from facts.toml and gc_registers.rdl, which say what each is; do not edit.

library ieee;
  use ieee.std_logic_1164.all;

package gc_facts_pkg is

  -- States of the brakes.

  subtype safety_state_t is std_ulogic_vector(2 downto 0);

  constant state_braked_c  : safety_state_t := "000";
  constant state_holding_c : safety_state_t := "011";
  constant state_run_c     : safety_state_t := "101";
  constant state_fault_c   : safety_state_t := "110";

  -- Causes, bit by bit; docs/guide/safety.md says when each is present.
  constant causes_c : positive := 17;
  constant cause_estop_c        : natural := 0;
  constant cause_encoder_c      : natural := 1;
  constant cause_crc_c          : natural := 2;
  constant cause_rom_c          : natural := 3;
  constant cause_speed_c        : natural := 4;
  constant cause_position_c     : natural := 5;
  constant cause_saturation_c   : natural := 6;
  constant cause_watchdog_c     : natural := 7;
  constant cause_result_c       : natural := 8;
  constant cause_unreferenced_c : natural := 9;
  constant cause_command_c      : natural := 10;
  constant cause_hold_c         : natural := 11;
  constant cause_brake_c        : natural := 12;
  constant cause_clock_c        : natural := 13;
  constant cause_core_c         : natural := 14;
  constant cause_upset_c        : natural := 15;
  constant cause_following_c    : natural := 16;

  subtype causes_t is std_ulogic_vector(causes_c - 1 downto 0);

  constant no_causes_c : causes_t := (others => '0');

  -- Causes that are faults while braked, too.
  constant always_causes_c : causes_t := "01101000000001111";

  -- Loading: the key, and the registers that it guards, in blocks of 16 bytes.
  constant load_key_c   : std_ulogic_vector(31 downto 0) := x"4B455953";
  constant load_block_c : std_ulogic_vector(11 downto 4) := x"62";

  -- Words of records that the host can read at once.
  constant record_window_c : positive := 64;

  constant operand_bits_c          : positive := 18;
  constant image_word_bits_c       : positive := 32;
  constant speed_address_bits_c    : positive := 9;
  constant position_address_bits_c : positive := 8;

  -- Latencies.
  constant activation_clocks_c     : positive := 3;
  constant speed_meter_clocks_c    : positive := 3;
  constant compensator_clocks_c    : positive := 14;
  constant current_scaler_clocks_c : positive := 4;
  constant drive_clocks_c          : positive := 6;

  -- Sections of an image.
  constant hidden_section_c   : natural := 0;
  constant output_section_c   : natural := 1;
  constant friction_section_c : natural := 2;
  constant mu_section_c       : natural := 3;
  constant position_section_c : natural := 4;
  constant scalar_section_c   : natural := 5;
  constant sections_c         : natural := 6;

end package gc_facts_pkg;
