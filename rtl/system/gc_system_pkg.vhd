-- SPDX-License-Identifier: MIT
--
-- The words that cross between the clock of the registers and that of the core: settings and commands one way, state
-- the other. Word k of a bus is bits 32 k + 31 .. 32 k; three axes are three words, axis 1 first.

library ieee;
  use ieee.std_logic_1164.all;

package gc_system_pkg is

  constant axes_c : positive := 3;

  subtype word_t is std_ulogic_vector(31 downto 0);

  -- Settings: bits of word 0, then words.
  constant cfg_enable_c        : natural := 0;
  constant cfg_tick_enable_c   : natural := 1;
  -- one bit per axis
  constant cfg_home_c          : natural := 4;
  -- one clock each
  constant cfg_start_c         : natural := 8;
  constant cfg_kick_c          : natural := 9;
  constant cfg_clear_encoder_c : natural := 10;
  -- one bit per cause
  constant cfg_clear_fault_c   : natural := 16;

  constant cfg_tick_clocks_c : natural := 1;
  constant cfg_weights_c     : natural := 2;
  constant cfg_limit_c       : natural := 3;
  constant cfg_slew_c        : natural := 4;
  constant cfg_period_min_c  : natural := 5;
  constant cfg_saturation_c  : natural := 6;
  constant cfg_watchdog_c    : natural := 7;
  constant cfg_result_c      : natural := 8;
  constant cfg_brake_c       : natural := 9;
  constant cfg_index_c       : natural := 10;
  constant cfg_low_c         : natural := 13;
  constant cfg_high_c        : natural := 16;
  constant cfg_words_c       : natural := 19;

  subtype settings_t is std_ulogic_vector(32 * cfg_words_c - 1 downto 0);

  -- State: words; status, flags, control and load have the bits of the registers.
  constant sts_number_c         : natural := 0;
  constant sts_missed_c         : natural := 1;
  constant sts_status_c         : natural := 2;
  constant sts_flags_c          : natural := 3;
  constant sts_cause_c          : natural := 4;
  constant sts_fault_c          : natural := 5;
  constant sts_first_cause_c    : natural := 6;
  constant sts_position_c       : natural := 7;
  constant sts_period_c         : natural := 10;
  constant sts_force_c          : natural := 13;
  constant sts_current_c        : natural := 16;
  constant sts_command_c        : natural := 19;
  constant sts_position_now_c   : natural := 22;
  constant sts_first_position_c : natural := 25;
  constant sts_control_c        : natural := 28;
  constant sts_load_c           : natural := 29;
  constant sts_bank_crc_c       : natural := 30;
  constant sts_words_c          : natural := 31;

  subtype state_t is std_ulogic_vector(32 * sts_words_c - 1 downto 0);

  -- What is loaded: a word of the image or, beside a command, its CRC, and which of these it is.
  constant load_word_c   : natural := 32;
  constant load_begin_c  : natural := 33;
  constant load_commit_c : natural := 34;
  constant load_rom_c    : natural := 35;

  subtype load_t is std_ulogic_vector(35 downto 0);

  -- Words number k to k + n - 1 of a bus.

  function words (
    bus_word : std_ulogic_vector;
    k        : natural;
    n        : positive := 1
  ) return std_ulogic_vector;

end package gc_system_pkg;

package body gc_system_pkg is

  function words (
    bus_word : std_ulogic_vector;
    k        : natural;
    n        : positive := 1
  ) return std_ulogic_vector is
  begin

    return bus_word(32 * (k + n) - 1 downto 32 * k);

  end function words;

end package body gc_system_pkg;
