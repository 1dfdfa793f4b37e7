#!/bin/sh
# Everything that rtl/registers/gc_registers.rdl and facts.toml describe, and the IP-XACT component that holds it, written
# below a folder (default: this project).
set -eu
cd "$(dirname "$0")/.."
out=${1:-.}
version=$(.venv/bin/python -c 'import gravcomp; print(gravcomp.__version__)')
properties=$(.venv/bin/python -c 'import importlib.resources as r; print(r.files("peakrdl_regblock_vhdl") / "hdl_src")')
peakrdl() {
    exporter=$1
    shift
    .venv/bin/peakrdl "$exporter" "$properties/regblock_udps.rdl" rtl/registers/gc_registers.rdl "$@"
}

mkdir -p "$out/rtl/registers" "$out/host" "$out/build" "$out/docs/guide" "$out/sim/gravcomp"
peakrdl regblock-vhdl -o "$out/rtl/registers" --cpuif axi4-lite-flat --default-reset rst --type-style hier --addr-width 12 \
    --err-if-bad-addr --err-if-bad-rw
.venv/bin/python -m gravcomp_lab.registers.plain_vhdl "$out/rtl/registers/gc_registers_pkg.vhd" "$out/rtl/registers/gc_registers.vhd"
peakrdl c-header -o "$out/host/gravcomp_registers.h" --std gnu99 --type-style hier
peakrdl html -o "$out/build/registers"
peakrdl ip-xact -o "$out/build/gc_registers.xml" --standard 2009 --vendor gravcomp --library gravcomp \
    --version "$version"
.venv/bin/python -m gravcomp_lab.registers.facts "$out/build/gc_registers.xml" "$out"
.venv/bin/python -m gravcomp_lab ipxact "$out/build/gc_registers.xml" --out "$out/rtl"
