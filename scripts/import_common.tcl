# SPDX-License-Identifier: MIT
#
# What the three import scripts share. Runs in plain Tcl 8.5 or later.

# The project to make, as a dictionary, from arguments NAME=VALUE: top (default gc_force_path), part, out (its folder);
# any other NAME is a generic of the top entity. defaults: part and out of the vendor.
#   sources       absolute paths, in compile order
#   constraints   absolute path of the top's constraints with that extension, or nothing
#   generics      dictionary
proc gravcomp_project {arguments defaults extension} {
    set root [file dirname [file dirname [file normalize [info script]]]]
    set project [dict merge {top gc_force_path generics {}} $defaults]
    foreach argument $arguments {
        if {![regexp {^(\w+)=(.+)$} $argument -> name value]} {
            error "need arguments NAME=VALUE, got $argument"
        }
        if {$name in {top part out}} {
            dict set project $name $value
        } else {
            dict set project generics $name $value
        }
    }
    set top [dict get $project top]
    set sources {}
    foreach name [gravcomp_read $root/rtl/sources.f] {
        lappend sources $root/rtl/$name
    }
    gravcomp_check_generics $top [lsearch -inline $sources */$top.vhd] [dict keys [dict get $project generics]]
    dict set project out [file normalize [dict get $project out]]
    dict set project sources $sources
    dict set project constraints [glob -nocomplain $root/constraints/$top.$extension]
    return $project
}

proc gravcomp_check_generics {top file names} {
    if {$file eq ""} {
        error "no entity $top: rtl/sources.f has no $top.vhd"
    }
    regexp {generic \((.*?)port \(} [gravcomp_read $file] -> generics
    foreach name $names {
        if {![regexp "\\m$name\\M *:" $generics]} {
            error "$top has no generic $name"
        }
    }
}

proc gravcomp_read {file} {
    set channel [open $file]
    set text [read $channel]
    close $channel
    return $text
}
