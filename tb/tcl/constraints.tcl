# SPDX-License-Identifier: MIT
#
# Reads a constraint file against a list of port bits:  tclsh constraints.tcl FILE PORT...
# Prints what it constrains, a line each: the command, then the ports or clocks. A pattern without a port, a clock that
# was not created, and options that the tools which read this kind of file do not have are errors.

set ports [lassign $argv file]
set clocks {}
set max_delay_options {-from -to}
if {[file extension $file] eq ".xdc"} {
    lappend max_delay_options -datapath_only
}

proc get_ports {patterns} {
    set found {}
    foreach pattern $patterns {
        set literal [string map {\[ \\\[ \] \\\]} $pattern]
        set matches [lsearch -all -inline -glob $::ports $literal]
        if {$matches eq {}} {
            error "no port $pattern"
        }
        lappend found {*}$matches
    }
    return $found
}

proc get_clocks {name} {
    if {$name ni $::clocks} {
        error "no clock $name"
    }
    return $name
}

proc create_clock {-name name -period period_ns ports} {
    lappend ::clocks $name
    puts [concat create_clock $period_ns $ports]
}

proc set_false_path {-from ports} {
    puts [concat set_false_path $ports]
}

proc set_max_delay {args} {
    foreach option [lsearch -all -inline -glob $args {-[a-z]*}] {
        if {$option ni $::max_delay_options} {
            error "set_max_delay has no option $option"
        }
    }
    set words [lsearch -all -inline -not -exact $args -datapath_only]
    puts [list set_max_delay [dict get [lrange $words 0 3] -from] [dict get [lrange $words 0 3] -to] [lindex $words 4]]
}

proc set_min_delay {-from from -to to delay_ns} {
    puts [list set_min_delay $from $to $delay_ns]
}

source $file
