#!/bin/sh
# Installs what is missing, and nothing else: GHDL, compilers, Icarus, Verilator, compilers, Python's run-time parts and the
# programs given as arguments with apt, the Python packages into .venv. Says nothing when all is there.
set -eu
cd "$(dirname "$0")/.."

install_packages() {
    command -v apt-get >/dev/null || { echo "setup: need $*, and there is no apt-get; install them by hand" >&2; exit 2; }
    as_root=
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || { echo "setup: need $*, and there is no sudo; install them as root" >&2; exit 2; }
        as_root=sudo
    fi
    $as_root apt-get update
    $as_root apt-get install --yes --no-install-recommends "$@"
}

command -v ghdl >/dev/null || install_packages ghdl
command -v cc >/dev/null || install_packages gcc libc6-dev
command -v c++ >/dev/null || install_packages g++
command -v tclsh >/dev/null || install_packages tcl
command -v iverilog >/dev/null || install_packages iverilog
command -v verilator >/dev/null || install_packages verilator
command -v c++ >/dev/null || install_packages g++
for program in "$@"; do command -v "$program" >/dev/null || install_packages "$program"; done
command -v python3 >/dev/null || install_packages python3-venv
python3 -c 'import ensurepip' 2>/dev/null || install_packages python3-venv
python3 -c 'import sys; sys.exit(sys.version_info < (3, 11))' ||
    { echo "setup: need Python 3.11 or newer, got $(python3 --version); install a newer python3" >&2; exit 2; }

wanted=$(cat pyproject.toml constraints.txt | sha256sum)
if [ "$(cat .venv/installed 2>/dev/null)" != "$wanted" ]; then
    python3 -m venv .venv
    .venv/bin/pip install --constraint constraints.txt --editable '.[dev,synth,registers]'
    # cocotb loads Python into the simulator and needs it as a shared library.
    [ -n "$(.venv/bin/find_libpython 2>/dev/null)" ] ||
        install_packages "$(python3 -c 'import sys; print("libpython%d.%d" % sys.version_info[:2])')"
    echo "$wanted" >.venv/installed
fi
