#!/bin/sh
# Everything that rtl/registers/gc_registers.rdl describes, written below a folder (default: this project).
set -eu
cd "$(dirname "$0")/.."
out=${1:-.}
properties=$(.venv/bin/python -c 'import importlib.resources as r; print(r.files("peakrdl_regblock_vhdl") / "hdl_src")')
peakrdl() {
    exporter=$1
    shift
    .venv/bin/peakrdl "$exporter" "$properties/regblock_udps.rdl" rtl/registers/gc_registers.rdl "$@"
}

mkdir -p "$out/rtl/registers" "$out/host"
peakrdl regblock-vhdl -o "$out/rtl/registers" --cpuif axi4-lite-flat --default-reset rst --type-style hier --addr-width 12 \
    --err-if-bad-addr --err-if-bad-rw --copy-utils-pkg
peakrdl ip-xact -o "$out/rtl/registers/gc_registers.xml" --vendor gravcomp --library gravcomp --version 0.1.0
peakrdl c-header -o "$out/host/gravcomp_registers.h" --std gnu99 --type-style hier
peakrdl html -o "$out/build/registers"
