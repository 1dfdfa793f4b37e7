#!/bin/sh
# Everything that rtl/registers/gc_registers.rdl and facts.toml describe but the VHDL of the registers, which `make rom`
# writes, and the IP-XACT component that holds them, written below a folder (default: this project). The C header, the
# pages and gc_registers.xml are those of eight axes, the component is that of rtl/generated.
set -eu
cd "$(dirname "$0")/.."
out=${1:-.}
version=$(.venv/bin/python -c 'import gravcomp; print(gravcomp.__version__)')
properties=$(.venv/bin/python -c 'import importlib.resources as r; print(r.files("peakrdl_regblock_vhdl") / "hdl_src")')
axes=$(sed -n 's/.*constant axes_c *: positive := \([0-9]*\);/\1/p' rtl/generated/gc_network_pkg.vhd)
peakrdl() {
    exporter=$1
    shift
    .venv/bin/peakrdl "$exporter" "$properties/regblock_udps.rdl" rtl/registers/gc_registers.rdl "$@"
}
ip_xact() {
    peakrdl ip-xact --standard 2009 --vendor gravcomp --library gravcomp --version "$version" "$@"
}

mkdir -p "$out/rtl/registers" "$out/host" "$out/build" "$out/docs/guide" "$out/sim/gravcomp"
peakrdl c-header -o "$out/host/gravcomp_registers.h" --std gnu99 --type-style hier
peakrdl html -o "$out/build/registers"
ip_xact -o "$out/rtl/registers/gc_registers.xml"
ip_xact -o "$out/build/component.xml" -P "AXES=$axes"
.venv/bin/python -m gravcomp_lab.registers.facts "$out/rtl/registers/gc_registers.xml" "$out"
.venv/bin/python -m gravcomp_lab ipxact "$out/build/component.xml" --out "$out/rtl"
