# SPDX-License-Identifier: MIT
#
# Vivado project of gravcomp:
#   vivado -mode batch -source scripts/vivado_import.tcl -tclargs "top=gc_force_path" "part=xc7a100tcsg324-1" "lanes_g=4"

source [file join [file dirname [info script]] import_common.tcl]
set project [gravcomp_project $argv {part xc7a100tcsg324-1 out build/vivado} xdc]

dict with project {
    create_project -force gravcomp $out -part $part
    set_property target_language VHDL [current_project]

    add_files -norecurse $sources
    set_property library gravcomp [get_files $sources]
    set_property file_type {VHDL 2008} [get_files $sources]

    if {[llength $constraints]} {
        add_files -fileset constrs_1 -norecurse $constraints
    }
    set_property top $top [current_fileset]
    set pairs {}
    dict for {name value} $generics {
        lappend pairs $name=$value
    }
    set_property generic $pairs [current_fileset]
    update_compile_order -fileset sources_1
}
