# SPDX-License-Identifier: MIT
#
# Quartus Prime project of gravcomp:
#   quartus_sh -t scripts/quartus_import.tcl top=gc_force_path part=5CSEBA6U23I7 lanes_g=4

package require ::quartus::project
package require ::quartus::device

source [file join [file dirname [info script]] import_common.tcl]
set project [gravcomp_project $argv {part 5CSEBA6U23I7 out build/quartus} sdc]

dict with project {
    file mkdir $out
    cd $out
    project_new gravcomp -overwrite
    set_global_assignment -name FAMILY [lindex [get_part_info -family $part] 0]
    set_global_assignment -name DEVICE $part
    set_global_assignment -name VHDL_INPUT_VERSION VHDL_2008
    set_global_assignment -name TOP_LEVEL_ENTITY $top

    foreach path $sources {
        set_global_assignment -name VHDL_FILE $path -library gravcomp -hdl_version VHDL_2008
    }
    foreach path $constraints {
        set_global_assignment -name SDC_FILE $path
    }
    dict for {name value} $generics {
        set_parameter -name $name $value
    }
    export_assignments
    project_close
}
