"""Writes the VHDL package of the compensator: which parts are used, their tables, the hash of compensation.csv."""

import hashlib
from pathlib import Path

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.compensation import COMPENSATION_CSV, Compensation
from gravcomp.core.compensator_tables import (
    FRICTION_BITS,
    N_POSITIONS,
    N_SPEEDS,
    PHASE_STEP_BITS,
    FixedCompensation,
    quantise_compensation,
)
from gravcomp.core.folder import printable_name
from gravcomp.robot.machine import Drive

COMPENSATION_PACKAGE_FILE = "gc_compensation_pkg.vhd"
_WORD_BITS = 2 * q.OPERAND_BITS
_WORDS_PER_LINE = 8


def compensation_package_text(folder: Path | str, constants: Compensation, drive: Drive) -> str:
    """VHDL text of gc_compensation_pkg from the constants in a machine folder; a transparent one if all are zero.

    Raises InputError when the constants cannot be held.
    """
    fixed = quantise_compensation(constants, drive, folder)
    path = Path(folder) / COMPENSATION_CSV
    digest = hashlib.sha256(path.read_bytes() if path.exists() else b"").hexdigest()
    return package_text(fixed, digest, printable_name(folder))


def package_text(fixed: FixedCompensation, sha256: str, name: str) -> str:
    """VHDL text of gc_compensation_pkg; sha256 and name of its compensation.csv and weights folder go into it."""
    return _TEMPLATE.format(
        name=name,
        sha256=sha256,
        friction_bits=FRICTION_BITS,
        phase_step_bits=PHASE_STEP_BITS,
        speed_words=2 * N_SPEEDS,
        position_words=N_POSITIONS,
        last_speed_word=fixed.n_axes * 2 * N_SPEEDS - 1,
        last_position_word=fixed.n_axes * N_POSITIONS - 1,
        word_high=_WORD_BITS - 1,
        last_axis=fixed.n_axes - 1,
        friction_used=_flags(fixed.friction),
        mu_used=_flags(fixed.mu),
        position_used=_flags(fixed.position),
        phase_steps=", ".join(f"{i} => {step}" for i, step in enumerate(fixed.phase_step)),
        friction_words=_words(fixed.friction),
        mu_words=_words(fixed.mu),
        position_words_text=_words(fixed.position),
    )


def _flags(words: np.ndarray) -> str:
    """One bit per axis, axis 1 rightmost: does the table hold anything but zeros?"""
    return "".join(str(int(axis.any())) for axis in words[::-1])


def _words(words: np.ndarray) -> str:
    """All axes' words, axis 1 first; a table of zeros throughout in one line."""
    if not words.any():
        return "    others => (others => '0')"
    mask = 2**q.OPERAND_BITS - 1
    literals = [
        f'x"{(int(step) & mask) << q.OPERAND_BITS | int(value) & mask:0{_WORD_BITS // 4}x}"'
        for value, step in words.reshape(-1, 2)
    ]
    lines = [literals[k : k + _WORDS_PER_LINE] for k in range(0, len(literals), _WORDS_PER_LINE)]
    return ",\n".join("    " + ", ".join(line) for line in lines)


_TEMPLATE = """\
-- SPDX-License-Identifier: MIT
--
-- Generated from weights/{name} by `make rom`; do not edit.
--
-- Tables of gc_compensator. A word is the value of a node, low, and the step to the next node, high, 18 bits each.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package gc_compensation_pkg is

  -- SHA-256 of compensation.csv, or of nothing where there is no such file.
  constant compensation_hash_c : std_ulogic_vector(255 downto 0) :=
    x"{sha256}";

  -- Width of an axis' friction, mN.
  constant friction_bits_c : positive := {friction_bits};

  -- Which axes have a table that is not zero throughout, axis 1 lowest.
  constant friction_used_c : std_ulogic_vector({last_axis} downto 0) := "{friction_used}";
  constant mu_used_c       : std_ulogic_vector({last_axis} downto 0) := "{mu_used}";
  constant position_used_c : std_ulogic_vector({last_axis} downto 0) := "{position_used}";

  -- Turns of the position table per count, 2**-32.
  constant phase_step_bits_c : positive := {phase_step_bits};

  type phase_steps_t is array (0 to {last_axis}) of natural;

  constant phase_step_c : phase_steps_t := ({phase_steps});

  subtype table_word_t is std_ulogic_vector({word_high} downto 0);

  -- Friction, mN, and mu, 2**-17, over the code of gc_speed_code: {speed_words} words per axis, axis 1 first.
  type speed_words_t is array (0 to {last_speed_word}) of table_word_t;

  constant friction_words_c : speed_words_t := (
{friction_words}
  );

  constant mu_words_c : speed_words_t := (
{mu_words}
  );

  -- Force, mN, over one pitch: {position_words} words per axis, axis 1 first.
  type position_words_t is array (0 to {last_position_word}) of table_word_t;

  constant position_words_c : position_words_t := (
{position_words_text}
  );

  -- The words of so many axes as one vector, word 0 of the first of them lowest.
  function speed_table (words : speed_words_t; first : natural; axes : positive) return std_ulogic_vector;

  function position_table (first : natural; axes : positive) return std_ulogic_vector;

  -- Phase steps as one vector, axis 1 lowest.
  function flat (steps : phase_steps_t) return signed;

end package gc_compensation_pkg;

package body gc_compensation_pkg is

  function speed_table (words : speed_words_t; first : natural; axes : positive) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(axes * {speed_words} * table_word_t'length - 1 downto 0);
  begin
    for i in 0 to axes * {speed_words} - 1 loop
      flat_v((i + 1) * table_word_t'length - 1 downto i * table_word_t'length) := words(first * {speed_words} + i);
    end loop;
    return flat_v;
  end function speed_table;

  function position_table (first : natural; axes : positive) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(axes * {position_words} * table_word_t'length - 1 downto 0);
  begin
    for i in 0 to axes * {position_words} - 1 loop
      flat_v((i + 1) * table_word_t'length - 1 downto i * table_word_t'length)
        := position_words_c(first * {position_words} + i);
    end loop;
    return flat_v;
  end function position_table;

  function flat (steps : phase_steps_t) return signed is
    variable flat_v : signed((steps'high + 1) * phase_step_bits_c - 1 downto 0);
  begin
    for i in steps'range loop
      flat_v((i + 1) * phase_step_bits_c - 1 downto i * phase_step_bits_c) := to_signed(steps(i), phase_step_bits_c);
    end loop;
    return flat_v;
  end function flat;

end package body gc_compensation_pkg;
"""
