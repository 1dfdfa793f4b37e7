#!/bin/sh
# Everything that the descriptions of the registers (rtl/registers/*.rdl) and facts.toml tell but the VHDL of the
# registers, which `make rom` writes, and the IP-XACT component that holds them, written below a folder (default: this
# project). C headers, pages and *.xml are those of eight axes, the component is that of rtl/generated.
set -eu
cd "$(dirname "$0")/.."
out=${1:-.}
version=$(.venv/bin/python -c 'import gravcomp; print(gravcomp.__version__)')
properties=$(.venv/bin/python -c 'import importlib.resources as r; print(r.files("peakrdl_regblock_vhdl") / "hdl_src")')
axes=$(sed -n 's/.*constant axes_c *: positive := \([0-9]*\);/\1/p' rtl/generated/gc_network_pkg.vhd)
peakrdl() {
    exporter=$1
    description=$2
    shift 2
    .venv/bin/peakrdl "$exporter" "$properties/regblock_udps.rdl" "rtl/registers/$description.rdl" "$@"
}
ip_xact() {
    peakrdl ip-xact "$@" --standard 2009 --vendor gravcomp --library gravcomp --version "$version"
}

mkdir -p "$out/rtl/registers" "$out/host" "$out/build" "$out/docs/guide" "$out/sim/gravcomp"
for description in gc_registers gc_motion_registers; do
    peakrdl c-header $description -o "$out/host/gravcomp_${description#gc_}.h" --std gnu99 --type-style hier
    peakrdl html $description -o "$out/build/${description#gc_}"
    ip_xact $description -o "$out/rtl/registers/$description.xml"
done
ip_xact gc_registers -o "$out/build/component.xml" -P "AXES=$axes"
.venv/bin/python -m gravcomp_lab.registers.facts "$out/rtl/registers" "$out"
.venv/bin/python -m gravcomp_lab ipxact "$out/build/component.xml" --out "$out/rtl"
