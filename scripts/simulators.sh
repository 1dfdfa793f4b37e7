#!/bin/sh
# Other simulators beside this machine's own GHDL: names one folder a line whose `ghdl` starts one, to put on the PATH.
# GHDL 5.0.1 is Debian 13's, unpacked with its libraries into build/simulators; ghdl-llvm is this system's package. What
# cannot be had is said on standard error, and is then not named.
set -eu
cd "$(dirname "$0")/.."
folder=$PWD/build/simulators

fetch_debian_13() {
    apt=$folder/apt
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' | head -n 1)
    [ -n "$mirror" ] || { echo "no mirror of Debian among the sources of apt" >&2; return 1; }
    keys=/usr/share/keyrings/debian-archive-keyring.gpg
    echo "deb [signed-by=$keys] $mirror trixie main" >"$apt/sources.list"
    set -- -o Dir::Etc::sourcelist="$apt/sources.list" -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists="$apt/lists" \
        -o Dir::Cache="$apt/cache" -o Dir::State::status=/dev/null -o APT::Sandbox::User= -o Debug::NoLocking=1
    apt-get "$@" update && apt-get "$@" install --yes --download-only --no-install-recommends ghdl-mcode || return 1
    for package in "$apt"/cache/archives/*.deb; do dpkg -x "$package" "$1" || return 1; done
}

unpack_ghdl_5() {
    root=$folder/debian-13
    [ -x "$root/usr/bin/ghdl-mcode" ] || (set -- "$root"; fetch_debian_13 "$root") || return 1
}

for backend in ghdl-5 ghdl-llvm; do
    echo $backend
done
