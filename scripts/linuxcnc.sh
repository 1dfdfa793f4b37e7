#!/bin/sh
# LinuxCNC's headers and HAL library from Debian's packages into build/linuxcnc, for the test of host/linuxcnc: unpacked, not
# installed, since the whole of it needs a desktop.
set -eu
cd "$(dirname "$0")/.."
mkdir -p build/linuxcnc/packages
cd build/linuxcnc/packages
apt-get download linuxcnc-uspace linuxcnc-uspace-dev
for package in *.deb; do dpkg -x "$package" ..; done
