# Written by `make regs`.

proc init_gui {IPINST} {
    ipgui::add_param $IPINST -name Component_Name
    ipgui::add_param $IPINST -name lanes_g
    ipgui::add_param $IPINST -name clock_hz_g
    ipgui::add_param $IPINST -name filter_samples_g
    ipgui::add_param $IPINST -name speed_timeout_g
    ipgui::add_param $IPINST -name reversal_clocks_g
    ipgui::add_param $IPINST -name dither_clocks_g
    ipgui::add_param $IPINST -name loadable_g
    ipgui::add_param $IPINST -name clock_watch_g
    ipgui::add_param $IPINST -name two_paths_g
    ipgui::add_param $IPINST -name brake_feedback_g
    ipgui::add_param $IPINST -name brake_test_g
    ipgui::add_param $IPINST -name guard_g
    ipgui::add_param $IPINST -name twin_g
    ipgui::add_param $IPINST -name motion_g
    ipgui::add_param $IPINST -name record_bits_g
}

proc update_PARAM_VALUE.lanes_g {PARAM_VALUE.lanes_g} {}

proc validate_PARAM_VALUE.lanes_g {PARAM_VALUE.lanes_g} {
    return true
}

proc update_MODELPARAM_VALUE.lanes_g {MODELPARAM_VALUE.lanes_g PARAM_VALUE.lanes_g} {
    set_property value [get_property value ${PARAM_VALUE.lanes_g}] ${MODELPARAM_VALUE.lanes_g}
}

proc update_PARAM_VALUE.clock_hz_g {PARAM_VALUE.clock_hz_g} {}

proc validate_PARAM_VALUE.clock_hz_g {PARAM_VALUE.clock_hz_g} {
    return true
}

proc update_MODELPARAM_VALUE.clock_hz_g {MODELPARAM_VALUE.clock_hz_g PARAM_VALUE.clock_hz_g} {
    set_property value [get_property value ${PARAM_VALUE.clock_hz_g}] ${MODELPARAM_VALUE.clock_hz_g}
}

proc update_PARAM_VALUE.filter_samples_g {PARAM_VALUE.filter_samples_g} {}

proc validate_PARAM_VALUE.filter_samples_g {PARAM_VALUE.filter_samples_g} {
    return true
}

proc update_MODELPARAM_VALUE.filter_samples_g {MODELPARAM_VALUE.filter_samples_g PARAM_VALUE.filter_samples_g} {
    set_property value [get_property value ${PARAM_VALUE.filter_samples_g}] ${MODELPARAM_VALUE.filter_samples_g}
}

proc update_PARAM_VALUE.speed_timeout_g {PARAM_VALUE.speed_timeout_g} {}

proc validate_PARAM_VALUE.speed_timeout_g {PARAM_VALUE.speed_timeout_g} {
    return true
}

proc update_MODELPARAM_VALUE.speed_timeout_g {MODELPARAM_VALUE.speed_timeout_g PARAM_VALUE.speed_timeout_g} {
    set_property value [get_property value ${PARAM_VALUE.speed_timeout_g}] ${MODELPARAM_VALUE.speed_timeout_g}
}

proc update_PARAM_VALUE.reversal_clocks_g {PARAM_VALUE.reversal_clocks_g} {}

proc validate_PARAM_VALUE.reversal_clocks_g {PARAM_VALUE.reversal_clocks_g} {
    return true
}

proc update_MODELPARAM_VALUE.reversal_clocks_g {MODELPARAM_VALUE.reversal_clocks_g PARAM_VALUE.reversal_clocks_g} {
    set_property value [get_property value ${PARAM_VALUE.reversal_clocks_g}] ${MODELPARAM_VALUE.reversal_clocks_g}
}

proc update_PARAM_VALUE.dither_clocks_g {PARAM_VALUE.dither_clocks_g} {}

proc validate_PARAM_VALUE.dither_clocks_g {PARAM_VALUE.dither_clocks_g} {
    return true
}

proc update_MODELPARAM_VALUE.dither_clocks_g {MODELPARAM_VALUE.dither_clocks_g PARAM_VALUE.dither_clocks_g} {
    set_property value [get_property value ${PARAM_VALUE.dither_clocks_g}] ${MODELPARAM_VALUE.dither_clocks_g}
}

proc update_PARAM_VALUE.loadable_g {PARAM_VALUE.loadable_g} {}

proc validate_PARAM_VALUE.loadable_g {PARAM_VALUE.loadable_g} {
    return true
}

proc update_MODELPARAM_VALUE.loadable_g {MODELPARAM_VALUE.loadable_g PARAM_VALUE.loadable_g} {
    set_property value [get_property value ${PARAM_VALUE.loadable_g}] ${MODELPARAM_VALUE.loadable_g}
}

proc update_PARAM_VALUE.clock_watch_g {PARAM_VALUE.clock_watch_g} {}

proc validate_PARAM_VALUE.clock_watch_g {PARAM_VALUE.clock_watch_g} {
    return true
}

proc update_MODELPARAM_VALUE.clock_watch_g {MODELPARAM_VALUE.clock_watch_g PARAM_VALUE.clock_watch_g} {
    set_property value [get_property value ${PARAM_VALUE.clock_watch_g}] ${MODELPARAM_VALUE.clock_watch_g}
}

proc update_PARAM_VALUE.two_paths_g {PARAM_VALUE.two_paths_g} {}

proc validate_PARAM_VALUE.two_paths_g {PARAM_VALUE.two_paths_g} {
    return true
}

proc update_MODELPARAM_VALUE.two_paths_g {MODELPARAM_VALUE.two_paths_g PARAM_VALUE.two_paths_g} {
    set_property value [get_property value ${PARAM_VALUE.two_paths_g}] ${MODELPARAM_VALUE.two_paths_g}
}

proc update_PARAM_VALUE.brake_feedback_g {PARAM_VALUE.brake_feedback_g} {}

proc validate_PARAM_VALUE.brake_feedback_g {PARAM_VALUE.brake_feedback_g} {
    return true
}

proc update_MODELPARAM_VALUE.brake_feedback_g {MODELPARAM_VALUE.brake_feedback_g PARAM_VALUE.brake_feedback_g} {
    set_property value [get_property value ${PARAM_VALUE.brake_feedback_g}] ${MODELPARAM_VALUE.brake_feedback_g}
}

proc update_PARAM_VALUE.brake_test_g {PARAM_VALUE.brake_test_g} {}

proc validate_PARAM_VALUE.brake_test_g {PARAM_VALUE.brake_test_g} {
    return true
}

proc update_MODELPARAM_VALUE.brake_test_g {MODELPARAM_VALUE.brake_test_g PARAM_VALUE.brake_test_g} {
    set_property value [get_property value ${PARAM_VALUE.brake_test_g}] ${MODELPARAM_VALUE.brake_test_g}
}

proc update_PARAM_VALUE.guard_g {PARAM_VALUE.guard_g} {}

proc validate_PARAM_VALUE.guard_g {PARAM_VALUE.guard_g} {
    return true
}

proc update_MODELPARAM_VALUE.guard_g {MODELPARAM_VALUE.guard_g PARAM_VALUE.guard_g} {
    set_property value [get_property value ${PARAM_VALUE.guard_g}] ${MODELPARAM_VALUE.guard_g}
}

proc update_PARAM_VALUE.twin_g {PARAM_VALUE.twin_g} {}

proc validate_PARAM_VALUE.twin_g {PARAM_VALUE.twin_g} {
    return true
}

proc update_MODELPARAM_VALUE.twin_g {MODELPARAM_VALUE.twin_g PARAM_VALUE.twin_g} {
    set_property value [get_property value ${PARAM_VALUE.twin_g}] ${MODELPARAM_VALUE.twin_g}
}

proc update_PARAM_VALUE.motion_g {PARAM_VALUE.motion_g} {}

proc validate_PARAM_VALUE.motion_g {PARAM_VALUE.motion_g} {
    return true
}

proc update_MODELPARAM_VALUE.motion_g {MODELPARAM_VALUE.motion_g PARAM_VALUE.motion_g} {
    set_property value [get_property value ${PARAM_VALUE.motion_g}] ${MODELPARAM_VALUE.motion_g}
}

proc update_PARAM_VALUE.record_bits_g {PARAM_VALUE.record_bits_g} {}

proc validate_PARAM_VALUE.record_bits_g {PARAM_VALUE.record_bits_g} {
    return true
}

proc update_MODELPARAM_VALUE.record_bits_g {MODELPARAM_VALUE.record_bits_g PARAM_VALUE.record_bits_g} {
    set_property value [get_property value ${PARAM_VALUE.record_bits_g}] ${MODELPARAM_VALUE.record_bits_g}
}
