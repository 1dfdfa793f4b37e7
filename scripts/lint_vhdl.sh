#!/bin/sh
# VHDL: GHDL's warnings as errors, the synthesizability of the tops, and the style rules of vsg.yaml.
set -eu
cd "$(dirname "$0")/../rtl"
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

options="--std=08 --workdir=$work"
warnings="--warn-error --warn-library --warn-binding --warn-reserved --warn-delayed-checks --warn-body --warn-specs
    --warn-runtime-error --warn-shared --warn-hide --warn-unused --warn-others --warn-pure --warn-static"

common=../boards/common
boards="$common/gc_pll.vhd $common/gc_power_on.vhd $common/gc_desk_axis.vhd $common/gc_board.vhd
    ../boards/ulx3s/ulx3s.vhd ../boards/colorlight_i5/colorlight_i5.vhd ../boards/arty_a7/arty_a7.vhd
    ../boards/de10_nano/de10_nano.vhd ../boards/tang-nano/tang_nano_20k.vhd"

# shellcheck disable=SC2086
{
    ghdl -a $options $warnings $(cat sources.f)
    ghdl -a $options $warnings $boards
    for top in ulx3s colorlight_i5 arty_a7 de10_nano tang_nano_20k; do
        ghdl --synth $options --out=none $top >"$work/$top.log" 2>&1 || { cat "$work/$top.log" >&2; exit 1; }
    done
    ghdl -a $options $warnings ../tb/hdl/*.vhd
    for top in gc_core gc_force_path gc_system gc_serial_system; do
        ghdl --synth $options --out=none $top >"$work/$top.log" 2>&1 || { cat "$work/$top.log" >&2; exit 1; }
    done
}
../.venv/bin/vsg --configuration ../scripts/vsg.yaml --filename $(grep -v "^registers/gc_\|^generated/" sources.f) $boards ../tb/hdl/*.vhd --output_format syntastic
