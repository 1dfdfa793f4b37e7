# SPDX-License-Identifier: MIT
#
# Radiant project of gravcomp:
#   radiantc scripts/radiant_import.tcl top=gc_force_path part=LIFCL-40-9BG400C lanes_g=4

source [file join [file dirname [info script]] import_common.tcl]
set project [gravcomp_project $argv {part LIFCL-40-9BG400C out build/radiant} sdc]

dict with project {
    file mkdir $out
    cd $out
    prj_create -name gravcomp -impl impl_1 -dev $part -synthesis synplify
    prj_set_strategy_value -strategy Strategy1 syn_vhdl2008=True

    # Library work, where the synthesizer looks for the top.
    foreach path $sources {
        prj_add_source $path -work work
    }
    foreach path $constraints {
        prj_add_source $path
    }
    prj_set_impl_opt -impl impl_1 top $top
    set pairs {}
    dict for {name value} $generics {
        lappend pairs $name=$value
    }
    if {[llength $pairs]} {
        prj_set_impl_opt -impl impl_1 HDL_PARAM [join $pairs {;}]
    }
    prj_save
    prj_close
}
