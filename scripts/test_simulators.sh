#!/bin/sh
# Runs tests on other simulators than this machine's GHDL: Debian 13's GHDL 5.0.1, unpacked beside it with its libraries
# into build/simulators, and ghdl-llvm. What cannot be had is said. Arguments are those of pytest.
# Fails when a test fails, or when no simulator could be had.
set -eu
cd "$(dirname "$0")/.."
folder=$PWD/build/simulators

# Packages of Debian 13 from the mirror that apt uses, into folders of our own: neither root nor the system's lists.
fetch_ghdl_5() {
    apt=$folder/apt
    mkdir -p "$apt/lists/partial" "$apt/cache/archives/partial"
    mirror=$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' 'Origin: Debian' | head -n 1)
    [ -n "$mirror" ] || { echo "apt knows no mirror of Debian"; return 1; }
    echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $mirror trixie main" >"$apt/sources.list"
    options="-o Dir::Etc::sourcelist=$apt/sources.list -o Dir::Etc::sourceparts=/dev/null -o Dir::State::lists=$apt/lists
        -o Dir::State::status=/dev/null -o Dir::Cache=$apt/cache -o APT::Sandbox::User=$(id -un) -o Debug::NoLocking=1"
    # shellcheck disable=SC2086
    apt-get $options update && apt-get $options install --yes --download-only --no-install-recommends ghdl-mcode || return 1
    for package in "$apt"/cache/archives/*.deb; do dpkg -x "$package" "$folder/debian-13" || return 1; done
}

have_ghdl_5() {
    root=$folder/debian-13
    [ -x "$root/usr/bin/ghdl-mcode" ] || fetch_ghdl_5 >"$folder/ghdl-5.log" 2>&1 || return 1
    loader=$(readlink -f "$(ls "$root"/usr/lib*/ld-linux-*.so.* | head -n 1)")
    libraries=$(dirname "$loader")
    cat >"$folder/ghdl-5/ghdl" <<SCRIPT
#!/bin/sh
# The loader and the libraries of Debian 13 first, then those of this system.
export GHDL_PREFIX=$root/usr/lib/ghdl/mcode/vhdl
exec $loader --library-path "$libraries:\${LD_LIBRARY_PATH:-}" $root/usr/bin/ghdl-mcode "\$@"
SCRIPT
}

have_ghdl_llvm() {
    command -v ghdl-llvm >"$folder/ghdl-llvm.log" || { echo "not installed" >"$folder/ghdl-llvm.log"; return 1; }
    printf '#!/bin/sh\nexec ghdl-llvm "$@"\n' >"$folder/ghdl-llvm/ghdl"
}

summary=
status=0
ran=0
for name in ghdl-5 ghdl-llvm; do
    mkdir -p "$folder/$name"
    if ! "have_$(echo $name | tr - _)"; then
        summary="$summary$name: NOT RUN, it cannot be had: $(tail -n 1 "$folder/$name.log")
"
        continue
    fi
    chmod +x "$folder/$name/ghdl"
    version=$("$folder/$name/ghdl" --version | sed -n '1p;3p' | tr -s '\n ' ' ' | sed 's/ *$//')
    echo "== $name: $version"
    if PATH="$folder/$name:$PATH" GRAVCOMP_BUILD="$folder/$name/build" .venv/bin/python -m pytest "$@"; then
        summary="$summary$name: passed ($version)
"
    else
        status=1
        summary="$summary$name: FAILED ($version)
"
    fi
    ran=1
done
printf '%s' "$summary"
[ $ran = 1 ] && exit $status
