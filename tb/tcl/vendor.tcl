# SPDX-License-Identifier: MIT
#
# Runs an import script against stubs of one vendor's commands:  tclsh vendor.tcl VENDOR SCRIPT ARGUMENT...
# Each command that the script gives is printed on a line, its words separated by tabs. Commands that the vendor does not
# have, options that a command does not have, files that do not exist, and commands without an open project are errors.

set open_project {}
set added {}

proc record {name words} {
    puts [join [concat [list $name] $words] \t]
}

# The words of a command without its options. options: name and number of values (0 or 1) of each that exists.
proc positional {name options words} {
    set rest {}
    while {[llength $words]} {
        set words [lassign $words word]
        if {![string match -* $word]} {
            lappend rest $word
        } elseif {![dict exists $options $word]} {
            error "$name has no option $word"
        } else {
            set words [lrange $words [dict get $options $word] end]
        }
    }
    return $rest
}

# Defines a command: its options, whether it needs an open project, and what to do with the other words.
proc command {name options needs_project body} {
    proc $name args "
        if {$needs_project && \$::open_project eq {}} {
            error {$name: no project is open}
        }
        record $name \$args
        set words \[positional $name [list $options] \$args\]
        $body
    "
}

proc need_file {path} {
    if {![file isfile $path]} {
        error "no file $path"
    }
    lappend ::added $path
}

proc need_one_of {value names} {
    if {$value ni $names} {
        error "no such name: $value"
    }
}

proc stub_vivado {} {
    command create_project {-force 0 -part 1} 0 {set ::open_project [lindex $words 0]}
    command current_project {} 1 {return project}
    command current_fileset {} 1 {return sources_1}
    command add_files {-norecurse 0 -fileset 1} 1 {foreach path [lindex $words 0] {need_file $path}}
    command get_files {} 1 {
        foreach path [lindex $words 0] {need_one_of $path $::added}
        return [lindex $words 0]
    }
    command set_property {} 1 {
        need_one_of [lindex $words 0] {target_language library file_type top generic}
        if {[llength $words] != 3} {error "set_property needs name, value and objects"}
    }
    command update_compile_order {-fileset 1} 1 {}
}

proc stub_quartus {} {
    package provide ::quartus::project 1.0
    package provide ::quartus::device 1.0
    command get_part_info {-family 0} 0 {return {{Cyclone V}}}
    command project_new {-overwrite 0} 0 {set ::open_project [lindex $words 0]}
    command set_global_assignment {-name 1 -library 1 -hdl_version 1} 1 {
        set name [lindex $args 1]
        need_one_of $name {FAMILY DEVICE VHDL_INPUT_VERSION TOP_LEVEL_ENTITY VHDL_FILE SDC_FILE}
        if {[string match *_FILE $name]} {need_file [lindex $words 0]}
    }
    command set_parameter {-name 1} 1 {}
    command export_assignments {} 1 {}
    command project_close {} 1 {set ::open_project {}}
}

proc stub_radiant {} {
    command prj_create {-name 1 -impl 1 -dev 1 -synthesis 1} 0 {set ::open_project [lindex $args 1]}
    command prj_set_strategy_value {-strategy 1} 1 {}
    command prj_add_source {-work 1} 1 {need_file [lindex $words 0]}
    command prj_set_impl_opt {-impl 1} 1 {need_one_of [lindex $words 0] {top HDL_PARAM}}
    command prj_save {} 1 {}
    command prj_close {} 1 {set ::open_project {}}
}

set argv [lassign $argv vendor script]
stub_$vendor
source $script
