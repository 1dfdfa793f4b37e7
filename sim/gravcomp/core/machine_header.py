"""Writes the C header of one machine: what its driver must find in the core."""

from gravcomp.robot.machine import Machine

MACHINE_HEADER_FILE = "gravcomp_machine.h"


def machine_header_text(machine: Machine, sha256: str, name: str) -> str:
    """C header with axes and clock of a machine folder and the first word of its hash, for gravcomp_settings."""
    return _TEMPLATE.format(name=name, axes=machine.n_axes, clock_hz=int(machine.clock_hz), weights=sha256[:8])


_TEMPLATE = """\
/* SPDX-License-Identifier: MIT
 *
 * Written by `make rom` from weights/{name}. Do not edit.
 */
#ifndef GRAVCOMP_MACHINE_H
#define GRAVCOMP_MACHINE_H

#define GRAVCOMP_MACHINE_AXES {axes}
#define GRAVCOMP_MACHINE_CLOCK_HZ {clock_hz}u
#define GRAVCOMP_MACHINE_WEIGHTS 0x{weights}u /* first word of weights_hash */

#endif
"""
