"""Each claim of a checker is refuted where the VHDL is broken: what takes faults of a file together."""

import re
import shutil

import pytest

import test_rtl_formal
from gravcomp_lab.formal.claims import CLAIMS, verify
from gravcomp_lab.synthesis.verilog import source_of
from runner import ROOT

CHECKERS = ROOT / "tb" / "formal"
BY_CHECKER = {claim.checker: claim for claim in CLAIMS}

# Checker, file, and its faults, which are planted together: VHDL, fault, assertion that must break.
PLANTED = [
    ("axi", "gc_registers", [
        ("axil_resp_wptr <= axil_resp_wptr + 1;", "axil_resp_wptr <= axil_resp_wptr + 2;",
         "no_read_response_without_request"),
        ("axil_n_in_flight < to_unsigned(2, 2)", "axil_n_in_flight < to_unsigned(3, 2)",
         "three_requests_of_a_kind_at_most"),
        ("s_axil_rdata <= axil_resp_buffer(to_integer(axil_resp_rptr(0 downto 0))).rdata;",
         "s_axil_rdata <= cpuif_rd_data;", "read_response_holds"),
    ]),
    ("axi", "gc_registers", [
        ("elsif axil_awvalid and axil_wvalid then", "elsif axil_awvalid then", "no_write_response_without_request"),
        ("elsif axil_arvalid then", "elsif axil_arvalid and not axil_prev_was_rd then", "reads_are_answered"),
        ("if cpuif_rd_ack or cpuif_wr_ack then", "if cpuif_rd_ack or (cpuif_wr_ack and not cpuif_wr_err) then",
         "writes_are_answered"),
        ("s_axil_bvalid <= '1';", "s_axil_bvalid <= not cpuif_req;", "write_response_holds"),
    ]),
    ("quad_decoder", "gc_quad_decoder", [
        ("step_illegal <= '0';\n      step_lost <= lost", "step_lost <= lost", "speed_meter_is_told_of_each_edge"),
        ("z_1 <= valid(2) and level(2);", "z_1 <= valid(1) and level(2);", "index_is_watched_once_it_is_known"),
    ]),
    ("safety", "gc_brake_sequencer", [
        ("=> '0');\n      if next_v = state_run_c then", "=> '0');\n      if next_v /= state_braked_c then",
         "brakes_are_engaged_but_in_run"),
        ("next_v = state_holding_c or next_v = state_run_c", "next_v /= state_braked_c",
         "command_is_zero_braked_and_in_fault"),
        ("enable_1 = '0' and in_healthy = '1'", "enable_1 = '0'", "motion_starts_by_an_edge_while_healthy"),
        ("next_v := state_holding_c;\n        end if;\n      elsif state = state_h",
         "next_v := state_run_c;\n        end if;\n      elsif state = state_h", "brakes_open_after_the_motors_hold"),
        ("if clear = '1' then", "if enable = '0' then", "fault_lasts_until_all_are_cleared_and_no_cause_is_present"),
    ]),
    ("interrupts", "gc_bus_side", [
        ("events /= in_state.fault_events", "events(0) /= in_state.fault_events(0)", "no_event_is_lost"),
    ]),
    ("interrupts", "gc_registers", [
        ("if hwif_in.interrupt_status.fault.next_q then -- stickybit\n            next_c := '1';",
         "if hwif_in.interrupt_status.fault.next_q and not decoded_reg_strb.interrupt_status then\n"
         "            next_c := '1';", "no_event_is_lost"),
    ]),
    ("safety", "gc_fault_latch", [
        ("(in_fault and not sts_fault) /= no_causes_c", "sts_fault = no_causes_c and in_fault /= no_causes_c",
         "every_fault_that_comes_is_an_event"),
    ]),
    ("safety", "gc_brake_sequencer", [
        (" or (enable = '1' and in_carried = '0')", "", "brakes_open_after_the_whole_command_was_reached"),
    ]),
    ("safety", "gc_brake_permit", [
        ("(enable and not in_carried)", "not in_carried", "both_paths_agree"),
    ]),
    ("safety", "gc_brake_sequencer", [
        ("next_v := state_run_c;", "next_v := not state_run_c;", "state_is_legal"),
    ]),
    ("safety", "gc_safety", [
        ("unsigned(in_deviates) = 0 or released = '0'", "unsigned(in_deviates) = 0", "command_is_absent_in_braked"),
        ("hold_1 and not released", "hold_1", "hold_is_absent_in_run"),
        ("state_holding_c and enable = '1' else '1'", "state_holding_c or enable = '1' else '1'",
         "hold_is_absent_in_braked"),
    ]),
    ("safety", "gc_safety", [
        ("in_upset = '1' or", "in_crc_bad = '1' or", "nothing_is_upset_of_itself"),
    ]),
    ("safety", "gc_safety", [
        ("when unsigned(in_deviates) = 0", "when unsigned(in_deviates) < 2", "lasting_deviation_engages_the_brakes"),
        ("hold_1 and not released", "hold_1 and released", "holding_ends_in_time"),
    ]),
    ("safety", "gc_safety", [
        ("estop_known and not estop_level(0)", "estop_known and estop_level(0)", "emergency_stop_engages_the_brakes"),
        ("period_limit(i) <= still_c;", "null;", "speed_is_held_against_every_limit"),
        ("if in_illegal(i) = '1'", "if in_illegal(0) = '1'", "lost_counts_engage_the_brakes"),
        ("if in_referenced(i) = '0'", "if in_referenced(0) = '0'", "lost_reference_engages_the_brakes"),
        ("if in_astray(i) = '1'", "if in_astray(0) = '1'", "following_error_engages_the_brakes"),
        ("state_braked_c else present", "state_holding_c else present", "causes_engage_the_brakes"),
        ("(sts_fault and not clear) = no_causes_c", "healthy = '1'", "fault_is_the_state_of_latched_causes"),
    ]),
    ("safety", "gc_fault_latch", [
        ("sts_fault and not in_clear", "sts_fault and in_clear", "causes_are_kept_until_each_is_cleared"),
        ("is_first = '1' else\n                first_cause", "is_first = '1' else\n                in_fault",
         "first_is_kept"),
    ]),
    ("safety", "gc_fault_latch", [
        ("sts_fault <= left;", "sts_fault <= left and not in_clear;", "only_cleared_causes_are_forgotten"),
        ("no_causes_c when left = no_causes_c else", "first_cause when left = no_causes_c else",
         "first_cause_is_there_with_a_fault"),
        ("in_fault when is_first", "(others => '1') when is_first", "first_cause_is_of_the_clock_that_led_to_fault"),
    ]),
    ("safety", "gc_fault_latch", [
        ("or in_fault when", "or in_fault(causes_c - 2 downto 0) & in_fault(causes_c - 1) when",
         "no_cause_comes_of_itself"),
    ]),
    ("parity_guard", "gc_parity_guard", [
        ("parity_of(in_next) when in_load = '1' else parity", "parity_of(in_next)", "parity_goes_along"),
        ("parity xor parity_of(in_word)", "parity or parity_of(in_word)", "nothing_else_is"),
        ("if rst = '1' then", "if rst = '1' and in_load = '1' then", "reset_forgets"),
    ]),
    ("parity_guard", "gc_parity_guard", [
        ("parity xor parity_of(in_word)", "parity and not parity_of(in_word)", "single_wrong_bit_is_found"),
    ]),
    ("lockstep", "gc_lockstep", [
        ("if in_twin /= main(lag_g) then", "if in_twin(0) /= main(lag_g)(0) then", "difference_is_seen_in_a_clock"),
        ("main(1) <= in_main;", "main(1) <= in_twin;", "equal_copies_are_no_difference"),
        ("if rst = '1' then", "if rst = '1' and in_twin = in_main then", "reset_is_no_difference"),
    ]),
    ("timeout", "gc_timeout", [
        ("not (is_short or restart or rst)", "not (is_short or rst)", "not_sooner"),
        ("in_next    => std_ulogic_vector(next_quiet)", "in_next    => std_ulogic_vector(quiet)",
         "counts_what_it_counted"),
    ]),
    ("timeout", "gc_timeout", [("quiet < cfg_clocks", "quiet <= cfg_clocks", "expires_after_the_limit")]),
    ("safety_told", "gc_safety", [
        ("in_count    => count_1,", "in_count    => in_count,", "position_is_that_of_the_first_cause"),
    ]),
    ("safety_told", "gc_fault_latch", [
        ("in_count when is_first = '1' else", "in_count when in_fault /= no_causes_c else",
         "position_is_kept_till_the_next_first_cause"),
    ]),
    ("safety_told", "gc_brake_feedback", [
        ("out_feedback <= level", "out_feedback <= told", "read_back_is_told_two_clocks_later"),
    ]),
    ("recorder_trigger", "gc_recorder", [
        ("          triggered <= '0';", "          triggered <= triggered;",
         "trigger_is_kept_till_recording_begins_anew"),
    ]),
    ("uart_receiving", "gc_uart", [
        ("receiving <= was_high and not level;", "receiving <= was_high;", "reception_begins_as_the_line_falls"),
        ("            receiving <= '0';\n            rx_valid", "            rx_valid",
         "character_comes_as_its_reception_ends"),
        ("        receiving <= '0';\n        rx_valid", "        rx_valid", "reset_ends_a_reception"),
    ]),
    ("fault_latch", "gc_fault_latch", [
        ("sts_fault and not in_clear", "sts_fault and in_clear", "latch_forgets_what_is_cleared_alone"),
        ("is_first = '1' else\n                first_cause", "is_first = '1' else\n                in_fault",
         "latch_tells_the_causes_of_the_first_clock"),
        ("in_count when is_first = '1' else", "in_count when in_fault /= no_causes_c else",
         "latch_tells_the_position_of_the_first_clock"),
        ("events <= events + 1;", "events <= events + 2;", "latch_counts_the_clocks_that_bring_a_cause"),
        ("in_next    => causes,", "in_next    => causes_1,", "latch_is_not_upset_of_itself"),
    ]),
    ("brake_sequencer", "gc_brake_sequencer", [
        ("        next_v := state_braked_c;\n      end if;\n\n      state <=",
         "        next_v := state_fault_c;\n      end if;\n\n      state <=", "sequencer_is_braked_by_reset"),
        ("if in_fault = '1' then", "if in_fault = '1' and enable = '1' then", "sequencer_ends_all_in_a_fault"),
        ("if clear = '1' then", "if clear = '0' then", "sequencer_leaves_a_fault_when_cleared"),
        ("enable_1 = '0' and in_healthy = '1'", "enable_1 = '0'", "sequencer_starts_by_an_edge_while_healthy"),
        ("elsif in_tested = '1' then", "else", "sequencer_runs_when_the_load_is_carried_and_the_test_over"),
        ("            next_v := state_braked_c;", "            next_v := state_fault_c;",
         "sequencer_holds_till_the_brakes_close"),
        ("if enable = '0' then\n          next_v := state_holding_c;",
         "if enable = '0' then\n          next_v := state_braked_c;", "sequencer_stops_by_holding"),
        ("next_v = state_holding_c or next_v = state_run_c", "next_v = state_run_c",
         "sequencer_commands_in_holding_and_run"),
        ("brake_release <= in_test;", "brake_release <= not in_test;", "sequencer_releases_in_run_and_test"),
        ("expired and not restart and enable;", "expired and enable;", "sequencer_tests_a_carried_load_alone"),
    ]),
    ("brake_sequencer", "gc_brake_sequencer", [
        ("next_v := state_run_c;", "next_v := not state_run_c;", "sequencer_has_four_states"),
    ]),
    *((checker, "gc_timeout", [
        ("in_next    => std_ulogic_vector(next_quiet)", "in_next    => std_ulogic_vector(quiet)", assertion),
    ]) for checker, assertion in (
        ("brake_sequencer", "sequencer_is_not_upset_of_itself"),
        ("brake_permit_guard", "permit_is_not_upset_of_itself"),
    )),
    ("glitch_sample", "gc_glitch_filter", [("  sample <= in_level;", "  sample <= level;", "sample_is_the_newest")]),
    ("synchronizer", "gc_synchronizer", [
        ("out_data <= stage(stages_g);", "out_data <= stage(stages_g - 1);", "pins_come_out_after_the_stages"),
        ("out_valid <= filled(stages_g);", "out_valid <= filled(stages_g - 1);", "pins_are_known_after_the_stages"),
    ]),
    ("brake_permit", "gc_brake_permit", [
        ("if in_fault = '1' or (shut", "if (shut", "faults_engage_the_brakes"),
        ("not (enable and was_low and in_healthy)", "not (enable and in_healthy)",
         "motion_starts_by_an_edge_while_healthy"),
        ("not (enable and in_tested)", "not enable", "brakes_open_after_the_load_is_carried_and_the_test"),
        ("if rst = '1' then", "if rst = '1' and enable = '0' then", "reset_engages_the_brakes"),
    ]),
    ("brake_permit", "gc_brake_permit", [
        ("idle_v or (shut_v and not in_test(i))", "shut_v and not in_test(i)",
         "brakes_are_engaged_but_in_run_and_test"),
        ("faulty_v := not clear", "faulty_v := not enable", "faulty_until_cleared"),
        ("idle_v := not enable;", "idle_v := not in_tested;", "command_ends_behind_closed_brakes"),
        ("(shut = '0' and idle = '1')", "(shut = '0' and enable = '0')", "faulty_by_a_fault"),
    ]),
    ("brake_permit", "gc_brake_permit", [
        ("        idle_v := '1';\n        shut_v := '1';\n      end if;\n      if rst",
         "        shut_v := '1';\n      end if;\n      if rst", "flags_do_not_contradict"),
    ]),
    ("brake_test", "gc_brake_test", [
        ("in_feedback /= fed", "in_feedback = fed", "wrong_read_back_fails"),
        ("going <= in_start and not rst;", "going <= not rst;", "nothing_without_a_start"),
        ("axis(axes_c - 2 downto 0) & '0'", "axis(axes_c - 2 downto 0) & '1'", "one_axis_at_a_time"),
    ]),
    ("brake_test", "gc_brake_test", [
        ("ends <= over and not idle", "ends <= over", "every_axis_in_its_phase"),
        ("second <= first;", "second <= not first;", "one_path_is_switched_at_a_time"),
        ("done <= axis(axes_c - 1)", "done <= axis(axes_c - 2)", "done_after_all_phases"),
        ("next_order <= next_axis &", "next_order <= axis &", "nothing_is_upset_of_itself"),
    ]),
    ("brake_feedback", "gc_brake_feedback", [
        ("(level(i) xnor told(i)) or not known", "level(i) xnor told(i)", "none_differs_before_the_pins_are_known"),
        ("unsigned(differs) /= 0", "differs(0) = '1'", "brakes_that_do_not_obey_differ"),
        ("out_feedback <= level", "out_feedback <= told", "pins_are_passed_on"),
    ]),
    ("brake_feedback", "gc_brake_feedback", [
        ("(level(i) xnor told(i)) or not known", "not known", "brakes_that_obey_do_not_differ"),
        ("when unsigned(upsets) /= 0", "when unsigned(upsets) = 0", "nothing_is_upset_of_itself"),
    ]),
    ("brakes", "gc_brakes", [
        ("pins_differ or test_failed", "pins_differ", "what_pins_or_test_find_is_wrong_and_nothing_else"),
        ("when unsigned(upsets) /= 0", "when unsigned(upsets) /= 0 or may_test = '1'", "nothing_is_upset_of_itself"),
    ]),
    ("brakes", "gc_brake_sequencer", [
        ("brake_release <= in_test;", "brake_release <= (others => '1');",
         "paths_differ_on_the_axis_in_its_test_alone"),
        ("next_v := state_fault_c;\n      end if;\n      if rst",
         "next_v := state_braked_c;\n      end if;\n      if rst",
         "faults_shut_the_brakes"),
        ("if next_v = state_holding_c or next_v = state_run_c then", "if next_v = state_run_c then",
         "command_is_active_in_holding_and_run"),
    ]),
    ("brakes", "gc_brake_sequencer", [
        ("brake_release <= (others => '0');", "brake_release <= in_test;", "both_paths_shut_the_brakes"),
        ("if next_v = state_run_c then", "if next_v = state_run_c and in_carried = '1' then",
         "both_paths_open_the_brakes"),
    ]),
    # One path alone opens no brake: both are told of every axis.
    ("brakes", "gc_brake_test", [
        ("out_first <= axis when", "out_first <= (others => '1') when", "brakes_are_shut_but_in_run_and_test"),
        ("out_second <= axis when", "out_second <= (others => '1') when", "brakes_are_shut_but_in_run_and_test"),
    ]),
    ("brakes", "gc_brake_test", [
        ("next_done <= axis(axes_c - 1);", "next_done <= axis(axes_c - 2);",
         "each_brake_is_tested_before_all_open"),
    ]),
    ("brakes", "gc_brake_feedback", [
        ("out_feedback <= level;", "out_feedback <= told;", "pins_are_passed_on"),
    ]),
    ("force_path", "gc_force_path", [
        ("start <= in_valid and", "start <= in_valid and not cfg_clear and", "none_lost"),
        ("in_ready <= core_ready and counts_valid and", "in_ready <= core_ready and", "reset_waits_for_the_encoders"),
        ("valid <= current_valid;\n", "valid <= current_valid or cfg_clear;\n", "none_invented"),
        ("if current_valid = '1' then", "if force_valid = '1' then", "command_holds_between_results"),
        ("        out_force <= (others => '0');\n", "", "reset_takes_the_command_to_zero"),
        ("sts_count <= count;", "sts_count <= not count;", "reset_clears_the_status"),
    ]),
    ("drive", "gc_drive", [
        ("below_1 <= '1';", "below_1 <= '0';", "stages_hold_what_they_should"),
        ("command <= command + step_5;", "command <= command + step_5 + 1;", "command_moves_by_the_slew_at_most"),
        ("above_1 or below_1 or above_4", "above_1 or above_4", "reached_is_the_whole_current"),
        ("out_limited(i) <= above_1 or below_1;", "out_limited(i) <= above_1;", "clipped_currents_are_flagged"),
        ("          out_deviates(i) <= '0';\n        end if;\n      end if;", "        end if;\n      end if;",
         "stop_is_zero_one_clock_later"),
        ("out_valid <= valid(5);", "out_valid <= valid(4);", "results_pass_through"),
    ]),
    ("drive", "gc_drive", [
        ("ceiling <= signed('0' & cfg_limit(magnitude_c));", "ceiling <= signed('0' & cfg_limit(magnitude_c)) + 1;",
         "limits_are_those_of_the_result"),
        ("step_5 <= rise;", "step_5 <= gap_3(bits_c - 1 downto 0);", "command_moves_by_the_slew_at_most"),
        ("if miss_7 > above or", "if miss_7 >= above or", "deviation_is_a_distance_beyond_the_bound"),
    ]),
    ("drive", "gc_drive", [
        ("command <= command + step_5;", "command <= command - step_5;",
         "command_stays_between_its_last_value_and_the_target"),
    ]),
    ("drive", "gc_drive", [
        ("        if valid(5) = '1' then\n          command", "        if valid(4) = '1' then\n          command",
         "command_and_flags_hold_between_results"),
    ]),
    ("drive", "gc_drive", [
        ("target_2 <= ceiling;", "target_2 <= asked_1;", "command_never_leaves_the_limits_given"),
    ]),
    ("servo", "gc_servo", [
        ("        correction <= (others => (others => '0'));\n", "", "stop_is_zero_one_clock_later"),
        ("correction(axis) <= ceiling(axis);", "correction(axis) <= whole_v(31 downto 0);",
         "correction_never_exceeds_its_limit"),
        ("out_valid <= feed_valid;", "out_valid <= feed_valid or in_valid;", "feed_forward_is_answered"),
        ("        out_valid <= '0';\n        out_current <= (others => '0');", "        out_valid <= '0';",
         "reset_clears"),
    ]),
    ("servo", "gc_servo", [
        ("saturate(sum_v, 32)", "sum_v(31 downto 0)", "sum_is_exact_or_saturated"),
        ("      if feed_valid = '1' then", "      if feed_valid = '1' or in_valid = '1' then", "command_holds_between"),
    ]),
    ("setpoint", "gc_setpoint", [
        ("setpoint(i) <= in_count(", "setpoint(i) <= not in_count(", "stopped_follows_the_count"),
        ("move_ready <= run when", "move_ready <= '1' when", "nothing_is_taken_while_stopped"),
        ("        state <= divide;", "        null;", "a_move_taken_is_under_way"),
        ("        start <= setpoint;\n", "        start <= setpoint;\n        setpoint(0) <= start(0);\n",
         "at_rest_it_stays"),
    ]),
    ("setpoint", "gc_setpoint", [
        # a division of one bit: the run that breaks it is short
        ("divide and bits_left = 0 then", "divide then", "each_tick_moves_once_at_most"),
        ("steps <= in_valid when", "steps <= '1' when", "each_tick_moves_once_at_most"),
    ]),
    ("recorder", "gc_recorder", [
        ("newest <= newest + words_c;", "newest <= newest + words_c + 1;", "places_follow_the_records"),
        ("if mode /= free_c then\n", "if mode = free_c then\n", "only_free_running_loses"),
    ]),
    ("recorder", "gc_recorder", [
        ("elsif records = capacity_c or records >= before then", "elsif records >= before then",
         "kept_words_are_never_overwritten"),
        ("mode /= off_c and done = '0'", "mode /= off_c", "off_and_done_record_nothing"),
        ("            keep <= '0';\n            if mode", "            if mode", "never_more_than_fit"),
    ]),
    ("recorder", "gc_recorder", [
        ("records_v := records_v + 1;", "records_v := records_v + 2;", "one_at_a_time"),
    ]),
    ("pwm", "gc_pwm", [
        ("elsif position < high and enable = '1' then", "elsif position < high then", "stop_is_low_one_clock_later"),
        ("else wave and negative;", "else wave;", "never_both_pins"),
    ]),
    ("pwm", "gc_pwm", [
        ("if wave = '0' and quiet = dead_g then", "if quiet = dead_g then", "signs_are_apart"),
    ]),
    ("phase", "gc_phase", [
        ("'0' & std_ulogic_vector(in_count", "in_count(half_bits_c - 1) & std_ulogic_vector(in_count",
         "halves_make_the_count"),
        ("coarse_step & fine_step", "coarse_step & coarse_step", "parts_make_the_fine_step"),
        ("in_valid  => valid_2(0),", "in_valid  => in_valid,", "none_invented"),
    ]),
    ("phase", "gc_phase", [
        ("coarse_step & fine_step", "fine_step & fine_step", "parts_make_the_coarse_step"),
        ("in_valid  => valid_2(0),", "in_valid  => '0',", "none_lost"),
    ]),
    ("sin_cos", "gc_sin_cos", [
        ('("" & in_phase(rest_bits_c - 1))', '("" & in_phase(rest_bits_c))', "place_and_rest_make_the_phase"),
        ("truncate(sum_6, 1, sum_bits_c - 1)", "truncate(sum_6, 1, operand_bits_c)", "results_are_clipped"),
        ("valid_7 <= valid_6;", "valid_7 <= valid_5(0);", "none_invented"),
    ]),
    ("sin_cos", "gc_sin_cos", [
        ("in_phase(rest_bits_c - 1 downto 0))), operand", "in_phase(rest_bits_c downto 0))), operand",
         "rest_is_half_a_place_at_most"),
        ("valid_6 <= valid_5(0);", "valid_6 <= '0';", "none_lost"),
    ]),
    ("tick", "gc_tick", [
        ("elapsed >= cfg_clocks", "elapsed > cfg_clocks", "none_left_out"),
        ("out_valid = '1' and in_ready = '0'", "in_ready = '0'", "missed_ticks_are_counted"),
        ("        out_valid <= '0';\n        sts", "        sts", "reset_clears"),
    ]),
    ("tick", "gc_tick", [
        ("elapsed >= cfg_clocks", "elapsed + 1 >= cfg_clocks", "none_early_or_unasked"),
    ]),
    ("speed_meter", "gc_speed_meter", [
        ("stamp <= now &", "stamp <= now - 1 &", "period_is_that_of_four_counts"),
        ("elsif idle = timeout_g - 1 then", "elsif idle = timeout_g - 2 then", "standstill_is_silence"),
        ("speed_valid <= valid_2 or zero_2;", "speed_valid <= valid_2;", "valid_is_five_edges_or_standstill"),
        ("if valid_2 = '0' then\n        speed_period <= slowest_c;", "if zero_2 = '1' then\n        null;",
         "unknown_is_slowest"),
        ("        speed_zero <= '0';\n        speed_period <= slowest_c;", "        speed_zero <= '0';",
         "reset_forgets"),
    ]),
    ("speed_meter", "gc_speed_meter", [
        ("now <= now + 1;", "now <= now + 2;", "time_stamps_are_ages"),
    ]),
    ("crossing_pulse", "gc_crossing_pulse", [
        ("in_valid = '1' and sent = answer", "in_valid = '1'", "one_at_most_is_under_way"),
        ("arrived <= arriving;", "arrived <= arrived;", "none_invented_or_doubled"),
        ("in_ready <= sent xnor answer;", "in_ready <= sent xor answer;",
         "none_is_taken_before_the_last_one_is_brought"),
    ]),
    ("crossing_pulse", "gc_crossing_pulse", [
        ("async_data(0) => sent,", "async_data(0) => '0',", "brought_in_time"),
    ]),
    ("crossing_pulse", "gc_crossing_pulse", [
        ("async_data(0) => arrived,", "async_data(0) => '0',", "ready_again_in_time"),
    ]),
    ("crossing_bus", "gc_crossing_bus", [
        ("in_valid = '1' and ready = '1'", "in_valid = '1'", "brought_whole_and_held"),
        ("out_valid <= '0';", "null;", "none_lost_but_in_reset"),
    ]),
    ("crossing_bus", "gc_crossing_pulse", [
        ("in_valid = '1' and sent = answer", "in_valid = '1'", "one_at_most_is_under_way"),
        ("arrived <= arriving;", "arrived <= arrived;", "none_invented_or_doubled"),
    ]),
    ("crossing_bus", "gc_crossing_pulse", [
        ("async_data(0) => sent,", "async_data(0) => '0',", "brought_in_time"),
    ]),
    ("crossing_bus", "gc_crossing_pulse", [
        ("async_data(0) => arrived,", "async_data(0) => '0',", "ready_again_in_time"),
    ]),
    ("crossing_bus", "gc_crossing_bus", [
        ("in_ready <= ready;", "in_ready <= '1';", "none_is_taken_before_the_last_one_is_brought"),
    ]),
    ("clock_monitor", "gc_clock_monitor", [
        ("if bus_expired = '1' or bus_rst = '1'", "if bus_rst = '1'", "core_that_stands_is_found"),
        ("bus_lost <= core_expired or (was_alive and not told_alive);", "bus_lost <= was_alive and not told_alive;",
         "bus_that_stands_is_found"),
    ]),
    ("clock_monitor", "gc_clock_monitor", [
        ("if bus_expired = '1' or bus_rst = '1'", "if bus_expired = '1'", "reset_waits_for_the_other_clock"),
        ("bus_lost <= core_expired or (was_alive and not told_alive);", "bus_lost <= core_expired;",
         "core_that_stood_is_told"),
    ]),
    ("loader", "gc_loader", [
        ("word = record_words_c(s) - 1", "word = record_words_c(s)", "place_is_that_of_the_words_so_far"),
        ("written <= index;", "written <= word;", "records_are_written_in_order"),
        ("kept <= load_word & kept(", "kept <= not load_word & kept(", "words_are_kept_in_order"),
        ("write_bank <= in_bank(0);", "write_bank <= in_bank(1);", "the_bank_in_use_is_not_written"),
        ("memory.bank <= in_bank;", "memory.bank <= not in_bank;", "the_bank_in_use_passes_through"),
        ("is_loading and section(sections_c)", "is_loading", "whole_images_alone_are_accepted"),
        ("      if load_begin = '1' then\n        crc <= crc_start_c;", "      if load_begin = '1' then\n",
         "crc_starts_anew"),
    ]),
    ("loader", "gc_loader", [
        ("write <= (others => '0');\n      if", "if", "nothing_else_is_written"),
        ("kept(scalar_bits_c - 1 downto 0)", "kept(scalar_bits_c downto 1)", "scalars_are_the_last_words"),
    ]),
    ("loader", "gc_loader", [
        ("bad <= not is_right;", "bad <= '0';", "others_are_refused"),
        ("        crc <= crc_step(crc, load_word);\n", "      end if;\n      if load_valid = '1' then\n"
         "        crc <= crc_step(crc, load_word);\n      end if;\n      if takes = '1' then\n",
         "crc_is_of_the_words_taken"),
    ]),
    ("bank_switch", "gc_bank_switch", [
        ("if in_start = '1' and in_done = '0' then", "if in_start = '1' then", "counts_inferences"),
        ("waiting <= '1';\n        next_bank <= \"00\";", "waiting <= '1';", "last_one_asked_is_next"),
        ("if load_begin = '1' or rst = '1' then", "if rst = '1' then", "waits_until_it_is_swapped_or_dropped"),
        ("out_hold <= waiting or restart;", "out_hold <= waiting;", "no_inference_begins_while_a_swap_waits"),
        ("        scalars <= in_scalars;", "        scalars <= scalars;", "all_constants_are_swapped_together"),
        ("restart <= swap;", "restart <= waiting;", "restart_comes_with_the_constants"),
    ]),
    ("bank_switch", "gc_bank_switch", [
        ("under_way = 0", "under_way < 2", "constants_change_between_inferences_only"),
        ("waiting and not load_begin", "waiting", "constants_change_when_asked_only"),
        ("restart <= swap;", "restart <= '0';", "swaps_once_none_is_under_way"),
        ("        crc <= (others => '0');\n      end if;", "      end if;", "reset_returns_to_the_rom"),
    ]),
    ("friction", "gc_friction", [
        ("valid <= in_valid & valid(1 to valid'high - 1);",
         "valid <= in_valid & in_valid & valid(1 to valid'high - 2);", "comes_after_twelve_clocks"),
        ("if force_7(force_7'high) = '1' then", "if force_7(force_7'low) = '1' then",
         "load_is_multiplied_by_its_magnitude"),
        ("sliding_v(mu_fraction_c - 1) := '1';", "sliding_v(mu_fraction_c - 2) := '1';", "sum_is_exact_and_rounded"),
    ]),
    ("friction", "gc_speed_code", [
        ("valid_3 <= valid_2;", "valid_3 <= valid_1;", "place_comes_after_three_clocks"),
    ]),
    ("input_clamp", "gc_input_scaler", [
        ("count_shift_c(axis), operand_bits_c)", "count_shift_c(axis) + 1, operand_bits_c)",
         "counts_in_range_are_multiplied_whole"),
        ("x_v := scalars.x_high(", "x_v := scalars.x_low(", "counts_outside_are_clamped"),
        ("if count < scalars.count_low(", "if count <= scalars.count_low(", "clamped_counts_are_flagged"),
    ]),
    ("uart", "gc_uart", [
        ("tx_level <= '0';", "tx_level <= '1';", "line_is_that_of_the_character"),
        ("tx_bits <= (odd_c(parity_g) xor parity_of(in_data)) & in_data;",
         "tx_bits <= (odd_c(parity_g) xor parity_of(in_data)) & not in_data;", "bits_go_along"),
        ("tx_left <= bits_c + 1;", "tx_left <= bits_c;", "time_goes_along"),
    ]),
    ("uart", "gc_uart", [
        ("tx_phase <= tx_phase + baud_g;", "tx_phase <= 0;", "phase_goes_along"),
        ("in_ready <= '1' when tx_left = 0", "in_ready <= '1' when tx_left /= 1", "next_one_is_taken_when_all_is_sent"),
    ]),
    ("uart_received", "gc_uart", [
        ("rx_data <= majority & rx_data", "rx_data <= not majority & rx_data", "what_comes_is_what_was_sent"),
    ]),
    ("uart_received", "gc_uart", [
        ("            rx_valid <= '1';", "            rx_valid <= '0';", "one_has_come_before_the_next_is_taken"),
    ]),
    ("biss", "gc_biss", [
        ("crc /= left_c or word(1) = '0' or", "word(1) = '0' or", "only_a_right_frame_is_taken"),
        ("signed(word(data_bits_c - 1 downto 2))", "signed(word(data_bits_c - 2 downto 2))",
         "position_is_that_of_the_frame"),
        ("sts_warning <= not word(0);", "sts_warning <= word(0);", "warning_is_that_of_the_frame"),
        ("        if slo(0) = '0' then\n          bad_v := '1';", "        if slo(0) = '0' then", "low_line_is_told"),
        ("        sts_error <= '1';\n        out_known <= '0';", "        sts_error <= '1';",
         "unknown_with_a_new_error"),
        ("= rest then\n        ma <= '1';", "= rest then\n        ma <= '0';", "line_is_high_without_a_frame"),
    ]),
    ("biss", "gc_biss", [
        ("              out_valid <= '1';\n", "", "position_holds_between_frames"),
        ("if cfg_clear = '1' then", "if in_valid = '1' then", "error_lasts_until_it_is_cleared"),
        ("clocks = half_clocks_g - 1 then", "clocks = half_clocks_g - 2 then", "line_rests_between_frames"),
        ("            good <= '0';", "            good <= '1';", "every_frame_ends_in_a_position_or_an_error"),
    ]),
    ("biss", "gc_biss", [
        ("out_known <= '0';\n      end if;\n\n      if rst", "out_known <= '1';\n      end if;\n\n      if rst",
         "unknown_until_a_frame_is_right"),
        ("waits <= waits + 1;", "waits <= waits;", "frame_ends_in_time"),
    ]),
    ("biss", "gc_biss", [
        ("waits <= 0;", "waits <= 1;", "gives_up_after_the_periods"),
    ]),
    ("biss", "gc_biss", [
        ("out_known <= '0';\n      end if;\n\n      if rst", "out_known <= '1';\n      end if;\n\n      if rst",
         "every_frame_ends_in_a_position_or_unknown"),
    ]),
    ("adc_spi", "gc_adc_spi", [
        ("clocks = half_clocks_g - 1 then", "clocks = half_clocks_g - 2 then", "half_a_period_is_whole"),
        ("state = high and bits /= frame_bits_g - 1)", "state = high and bits /= frame_bits_g - 2)",
         "frames_are_whole"),
        ("gap = gap_clocks_g then", "gap = gap_clocks_g - 1 then", "frames_are_apart"),
        ("state <= trail;", "state <= trail;\n          pin_mosi <= not send(0);", "data_change_as_the_clock_falls"),
        ("sense_valid <= (others => '0');\n      if", "if", "one_code_at_a_time"),
        ("errors <= errors + 1;", "errors <= errors + 2;", "errors_are_counted_one_by_one"),
    ]),
    ("adc_spi", "gc_adc_spi", [
        ("      pin_sclk <= '1';\n        elsif", "      pin_sclk <= '0';\n        elsif",
         "clock_rests_high_between_frames"),
        ("            sense_valid(i) <= '1';\n", "", "currents_hold_between_codes"),
    ]),
    ("modbus", "gc_modbus", [
        ("or length < shortest_c or unsigned(crc) /= 0 then", "or length < shortest_c then",
         "only_a_right_frame_is_carried_out"),
        ("bad <= bad or rx_error;", "bad <= rx_error;", "crc_is_that_of_the_frame"),
        ("silence <= silence + 1;", "silence <= silence;", "silence_is_that_of_the_line"),
    ]),
    ("modbus", "gc_modbus", [
        ("length <= length + 1;", "length <= length;", "length_is_that_of_the_frame"),
        ("if length = k then", "if length = k + 1 then", "unit_is_that_of_the_frame"),
        ('std_ulogic_vector(waddr) & "00";', 'std_ulogic_vector(waddr) & "01";', "accesses_are_of_whole_words"),
        ('m_axi_awprot <= "000";', 'm_axi_awprot <= "001";', "no_access_has_a_protection"),
        ("tx_enable <= '1' when state = load", "tx_enable <= '1' when state = idle", "no_answer_but_to_a_right_frame"),
        ("tx_valid <= '1' when state = send", "tx_valid <= '1' when state = idle", "character_waits_for_the_line"),
    ]),
    # From a power-up in the middle of an access: a whole frame before it would be a long run.
    ("modbus", "gc_modbus", [
        ("signal awvalid : std_ulogic := '0';", "signal awvalid : std_ulogic := '1';", "no_write_but_of_a_right_frame"),
        ("signal arvalid : std_ulogic := '0';", "signal arvalid : std_ulogic := '1';", "no_read_but_for_a_right_frame"),
        ("if m_axi_awready = '1' then", "if m_axi_awready = '0' then", "address_waits_for_the_bus"),
        ("if m_axi_arready = '1' then", "if m_axi_arready = '0' then", "read_waits_for_the_bus"),
        ("signal wvalid  : std_ulogic := '0';", "signal wvalid  : std_ulogic := '1';", "one_write_at_a_time"),
        ("if m_axi_wready = '1' then", "if m_axi_wready = '0' then", "data_waits_for_the_bus"),
        ("signal reading : std_ulogic := '0';", "signal reading : std_ulogic := '1';", "one_read_at_a_time"),
    ]),
    ("modbus", "gc_modbus", [
        ("signal state : state_t := idle;", "signal state : state_t := write;", "only_a_right_frame_is_carried_out"),
        ("signal awvalid : std_ulogic := '0';", "signal awvalid : std_ulogic := '1';", "no_write_but_of_a_right_frame"),
        ("signal wvalid  : std_ulogic := '0';", "signal wvalid  : std_ulogic := '1';", "one_write_at_a_time"),
        ("elsif m_axi_bvalid = '1' or waited", "elsif waited", "no_write_follows_a_refused_one"),
    ]),
    ("register_split", "gc_register_split", [
        ("in_aw_high);\n  awready", "not in_aw_high);\n  awready", "address_of_a_write_goes_to_its_block"),
        ("(out_awready, in_aw_high) and not writing", "(out_awready, in_aw_high)",
         "address_of_a_write_is_taken_by_its_block"),
        ("pair_of(in_wvalid and data_due,", "pair_of(in_wvalid,", "data_follow_their_address"),
        ("chosen(out_wready, to_high)", "chosen(out_wready, in_aw_high)", "data_are_taken_by_their_block"),
        ("chosen(out_bvalid, to_high) and writing", "chosen(out_bvalid, to_high)", "write_is_answered_by_its_block"),
        ("pair_of(in_bready and writing, to_high)", "pair_of(in_bready and writing, of_high)",
         "answer_to_a_write_is_taken_from_its_block"),
        ("pair_of(in_arvalid and not reading,", "pair_of(in_arvalid,", "address_of_a_read_goes_to_its_block"),
        ("chosen(out_arready, in_ar_high)", "chosen(out_arready, of_high)", "address_of_a_read_is_taken_by_its_block"),
        ("chosen(out_rvalid, of_high)", "chosen(out_rvalid, in_ar_high)", "read_is_answered_by_its_block"),
        ("pair_of(in_rready and reading, of_high)", "pair_of(in_rready, of_high)",
         "answer_to_a_read_is_taken_from_its_block"),
        ("write_high <= to_high;", "write_high <= not to_high;", "response_is_told_apart"),
        ("data_due <= '1';\n        to_high", "to_high", "one_access_of_a_kind_at_a_time"),
    ]),
    ("motion_bus_access", "gc_register_split", [
        ("pair_of(in_awvalid and not writing,", "pair_of(in_awvalid,", "write_to_the_block_is_passed_on"),
        ("(out_awready, in_aw_high) and not writing", "(out_awready, in_aw_high)", "write_waits_for_the_block"),
        ("chosen(out_wready, to_high) and data_due", "chosen(out_wready, to_high)", "data_are_taken_once"),
        ("pair_of(in_bready and writing, to_high)", "pair_of(in_bready and writing, of_high)",
         "answer_to_a_write_is_passed_on"),
        ("pair_of(in_arvalid and not reading,", "pair_of(in_arvalid,", "read_of_the_block_is_passed_on"),
        ("chosen(out_arready, in_ar_high)", "chosen(out_arready, of_high)", "read_waits_for_the_block"),
        ("chosen(out_rvalid, of_high) and reading", "chosen(out_rvalid, of_high)", "read_is_answered_once"),
        ("pair_of(in_rready and reading, of_high)", "pair_of(in_rready and reading, to_high)",
         "answer_to_a_read_is_passed_on"),
        ("chosen(out_bvalid, to_high) and writing", "chosen(out_bvalid, to_high)", "write_is_answered_once"),
    ]),
    ("motion_bus_access", "gc_motion_bus", [
        ("else m_axi_bresp;", "else bresp;", "block_answers_its_writes"),
        ("else m_axi_rresp;", "else rresp;", "block_answers_its_reads"),
        ("motion_command.move.value;", "motion_command.move.value or told;", "moves_as_it_was_commanded"),
        ("s_axil_wvalid  => wvalid(1)", "s_axil_wvalid  => wvalid(1) and s_axi_wstrb(0)", "own_writes_are_answered"),
    ]),
    ("motion_bus_access", "gc_motion_bus", [
        ("bresp when write_high", "bresp when s_axi_awaddr(11)", "own_answer_to_a_write_holds"),
        ("s_axi_rdata <= rdata when read_high", "s_axi_rdata <= rdata when s_axi_araddr(11)",
         "own_answer_to_a_read_holds"),
    ]),
    ("motion_bus_access", "gc_motion_registers", [
        ("is_valid_rw or (decoded_req and (decoded_addr = 16#A00#) and not decoded_req_is_wr)",
         "is_valid_rw or (decoded_req and (decoded_addr = 16#A00#))", "write_to_no_register_is_refused"),
        ("is_valid_rw or (decoded_req and (decoded_addr = 16#A04#) and decoded_req_is_wr)",
         "is_valid_rw or (decoded_req and (decoded_addr = 16#A04#) and not decoded_req_is_wr)",
         "write_to_a_register_is_not"),
        ("is_valid_addr or (decoded_req and (decoded_addr = 16#800#))",
         "is_valid_addr or (decoded_req and (decoded_addr = 16#804#))", "read_of_a_register_is_not"),
    ]),
    ("motion_bus_access", "gc_motion_registers", [
        ("readback_err <= decoded_err;", "readback_err <= '0';", "read_of_no_register_is_refused"),
        ("move_ticks <= decoded_req and (decoded_addr = 16#800#)",
         "move_ticks <= decoded_req and (decoded_addr = 16#804#)", "setting_is_as_it_was_written"),
        ("motion_command <= decoded_req and (decoded_addr = 16#A04#)",
         "motion_command <= decoded_req and (decoded_addr = 16#A08#)", "no_command_is_lost"),
    ]),
    ("motion_bus", "gc_motion_bus", [
        ("elsif asking = '0' and in_state.fetched = fetch.turn then", "elsif asking = '0' then",
         "one_question_at_a_time"),
        ("window_c when failed = '0' else", "window_c when in_alive = '1' else", "word_is_that_of_the_read"),
    ]),
    ("motion_bus", "gc_motion_bus", [
        ("s_axi_araddr(11),\n", "s_axi_araddr(10),\n", "nothing_is_asked_but_for_a_word"),
        ("if in_alive = '0' then", "if false then", "word_is_told_in_time"),
    ]),
    ("motion_bus", "gc_motion_bus", [
        ("          failed <= '0';\n", "", "error_only_where_the_clock_stood"),
        ("        told <= '0';\n      end if;\n      if rst",
         "        told <= '0';\n        fetch.address <= s_axi_araddr(7 downto 2);\n      end if;\n      if rst",
         "question_holds"),
        ("s_axi_rdata <= rdata when read_high", "s_axi_rdata <= rdata when s_axi_araddr(11)", "response_holds"),
    ]),
    ("motion", "gc_motion", [
        ("move_valid <= in_move and ready;", "move_valid <= in_move and move_ready;", "moves_only_while_released"),
        ("moves <= moves + 1;\n        not_taken <= not ready;", "moves <= moves + 1;", "no_move_is_taken_in_silence"),
        ("when clocks_left = until_taken_c else", "when clocks_left = until_taken_c - 1 else",
         "record_of_each_result_in_its_time"),
        ("if in_valid = '1' then\n        clocks_", "if in_valid = '1' and clocks_left = 0 then\n        clocks_",
         "busy_until_the_record_is_taken"),
        ("and records /= 0 and not", "and not", "no_record_goes_that_is_not_there"),
        ("(mode = fault_c and triggered = '0')", "(mode = fault_c and triggered = '1')",
         "no_record_of_a_fault_goes_before_it"),
        ("answered <= in_fetch.turn;", "answered <= not answered;\n        word <= read_word;",
         "word_is_that_at_its_address"),
        ("xor answered) and not drops;", "xor answered);", "no_word_as_a_record_goes"),
    ]),
    ("motion", "gc_motion", [
        ("if asked_2 = '1' and asked = '1' then", "if asked_2 = '1' then", "answer_is_to_the_question"),
        ("answered <= in_fetch.turn;", "answered <= not answered;", "answer_is_to_the_question"),
    ]),
    ("motion_current", "gc_motion", [
        ("feed_valid       => in_valid,", "feed_valid       => in_begins,",
         "each_result_has_its_current_a_clock_later"),
        ("feed_current     => in_current,", "feed_current     => in_position,", "current_is_the_sum_or_saturated"),
        ("in_count         => in_count,\n      in_valid         => in_begins,\n      move_valid",
         "in_count         => in_position,\n      in_valid         => in_begins,\n      move_valid",
         "stop_lets_setpoints_follow"),
        ("ready <= move_ready and released;", "ready <= move_ready or released;", "no_move_is_offered_but_in_run"),
        ("out_astray <= astray;", "out_astray <= not astray;", "astray_is_told"),
    ]),
    ("motion_current", "gc_servo", [
        ("      if feed_valid = '1' then", "      if feed_valid = '1' or in_valid = '1' then",
         "current_holds_between_results"),
        ("        out_valid <= '0';\n        out_current <= (others => '0');", "        out_valid <= '0';",
         "no_current_after_a_reset"),
        ("        correction <= (others => (others => '0'));\n", "", "stop_ends_corrections_and_errors"),
        ("correction(axis) <= ceiling(axis);", "correction(axis) <= whole_v(31 downto 0);",
         "limits_are_those_of_their_axes"),
    ]),
    ("serial_core", "gc_core_serial", [
        ("valid <= slot.ends and running;", "valid <= slot.ends;", "result_comes_at_the_latency_and_never_else"),
        ("saturate(y_sum, y_bits_c) &", "truncate(y_sum, 0, y_bits_c) &", "output_sum_is_clipped"),
        ("overflows(y_sum, y_bits_c) &", "overflows(y_sum, y_bits_c + 1) &", "clipped_output_is_flagged"),
        ("& saturated(saturated'high downto 1);", "& saturated(saturated'high - 1 downto 0);", "others_move_down"),
    ]),
    ("serial_core", "gc_core_serial", [
        ("if (slot.ends and running) = '1' or rst = '1' then", "if (slot.ends and running) = '1' then",
         "ready_at_rest_alone"),
        ("if takes_y = '1' then", "if slot.takes_h = '1' then", "forces_hold"),
    ]),
    *((checker, "gc_fixed_pkg", [
        ("limit_v := (others => not value_a(value_a'high));", "limit_v := (others => value_a(value_a'high));", clipped),
        ("for i in bits to value_a'high loop", "for i in bits to value_a'high - 1 loop", flagged),
    ]) for checker, clipped, flagged in (
        ("hidden_saturation", "sums_are_clipped", "sums_are_clipped"),
        ("output_saturation", "sums_are_clipped", "clipped_sums_are_flagged"),
        ("force_saturation", "forces_are_clipped", "clipped_forces_are_flagged"),
    )),
]  # fmt: skip

# About the checker itself, to help an induction: no fault of the VHDL can break it. And what is there to be broken: it
# tells the latency.
OF_THE_CHECKER = {
    "a_step_was_a_clock_ago_at_least",
    "edges_are_counted_from_a_turn",
    "fast_edges_follow_a_step",
    "limit_is_one_of_those_given",
    "reference_follows_a_homing",
    "results_are_six_clocks_apart",
    "time_never_wraps",
    "no_result",
}


def test_every_assertion_has_a_planted_fault():
    """Here or in test_rtl_formal.py, by its name."""
    broken = {assertion for *_, faults in PLANTED for *_, assertion in faults} | {
        p[-1] for p in test_rtl_formal.PLANTED
    }
    text = "".join(path.read_text() for path in CHECKERS.glob("*.sv"))
    written = set(re.findall(r"(\w+)\s*:\s*assert\b", text))
    assert written - broken == OF_THE_CHECKER


@pytest.mark.parametrize(
    ("checker", "file", "faults"),
    [
        pytest.param(
            *p, id=f"{p[0]}-{p[2][0][2]}", marks=[pytest.mark.slow] * (p[0] in ("axi", "interrupts", "force_path"))
        )
        for p in PLANTED
    ],
)
def test_planted_faults_are_refuted_together(checker, file, faults, tmp_path):
    shutil.copytree(ROOT / "rtl", tmp_path / "rtl")
    source = source_of(tmp_path / "rtl", file)
    text = source.read_text()
    for good, bad, _ in faults:
        assert text.count(good) == 1, good
        text = text.replace(good, bad)
    source.write_text(text)
    broken = {assertion for _, _, assertion in faults}
    verdict = verify(BY_CHECKER[checker], tmp_path / "rtl", CHECKERS, tmp_path / "out", broken)
    assert broken <= set(verdict.broken), verdict
