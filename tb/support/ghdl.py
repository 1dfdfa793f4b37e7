"""What the GHDL on the path cannot do."""

import subprocess

import pytest

VERSION = subprocess.run(["ghdl", "--version"], capture_output=True, text=True, check=True).stdout
# A bench that finds what it watches in generates, which VPI finds no other way, and the writer of a waveform.
walks_the_hierarchy = pytest.mark.skipif(
    "GHDL 5.0.1" in VERSION, reason="GHDL 5.0.1 dies of walking through the hierarchy (grt-avhpi.adb:593 and 732)"
)
