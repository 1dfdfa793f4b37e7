"""Writes the VHDL packages of one network: sizes, formats, constants, the words of the weight ROMs, the CSV's hash."""

from pathlib import Path

import numpy as np

from gravcomp.core import formats as q
from gravcomp.core.folder import folder_hash, load_folder, printable_name
from gravcomp.core.formats import FixedNetwork
from gravcomp.core.machine_header import MACHINE_HEADER_FILE, machine_header_text
from gravcomp.core.quantised import quantised
from gravcomp.core.vhdl.compensation_package import COMPENSATION_PACKAGE_FILE, compensation_package_text
from gravcomp.core.vhdl.registers import register_files
from gravcomp.files import write_all_atomically
from gravcomp.twin.precision import Precision, certified, precision

PACKAGE_FILE = "gc_network_pkg.vhd"


def rom_files(folder: Path | str) -> dict[str, str]:
    """The VHDL and the C header of a machine folder, its registers among them, text by file name.

    Raises InputError as load_folder does, when the hardware cannot hold a value, or when the formats cost too much.
    """
    return _rom_files(folder)[0]


def write_rom(folder: Path | str, generated: Path | str) -> Precision:
    """Write the packages of a machine folder to generated/; returns what the formats cost.

    Raises InputError as rom_files does; the old packages are then untouched.
    """
    texts, cost = _rom_files(folder)
    write_all_atomically({Path(generated) / name: text for name, text in texts.items()})
    return cost


def stale_rom_files(folder: Path | str, generated: Path | str) -> list[Path]:
    """The packages in generated/ that are not those of the weights folder. Raises InputError as rom_files does."""
    paths = {Path(generated) / name: text for name, text in rom_files(folder).items()}
    return [path for path, text in paths.items() if not _holds(path, text)]


def _rom_files(folder: Path | str) -> tuple[dict[str, str], Precision]:
    content = load_folder(folder)
    drive = content.machine.drive
    fixed, sha256 = quantised(content.machine, content.network, folder), folder_hash(folder, content.machine)
    cost = certified(precision(content.network, fixed, drive.unit_per_count), folder)
    texts = {
        PACKAGE_FILE: package_text(fixed, sha256, content.machine.clock_hz, printable_name(folder)),
        COMPENSATION_PACKAGE_FILE: compensation_package_text(folder, content.compensation, drive),
        MACHINE_HEADER_FILE: machine_header_text(content.machine, sha256, printable_name(folder)),
        **register_files(content.machine.n_axes),
    }
    return texts, cost


def _holds(path: Path, text: str) -> bool:
    try:
        return path.read_bytes() == text.encode("utf-8")
    except OSError:
        return False


def package_text(fixed: FixedNetwork, sha256: str, clock_hz: float, name: str) -> str:
    """VHDL text of gc_network_pkg for one network; hash, clock and name of its machine folder go into it."""
    machine = {"name": name, "sha256": sha256, "clock_hz": int(clock_hz)}
    return _TEMPLATE.format(**machine, **_sizes(fixed), **_scalars(fixed), **_weights(fixed), **_places(fixed))


def _sizes(fixed: FixedNetwork) -> dict:
    """Numbers of axes, inputs and neurons, the form, and widths that no network changes."""
    return {
        "n_axes": fixed.n_axes,
        "n_inputs": fixed.n_inputs,
        "n_hidden": fixed.n_hidden,
        "lean": str(fixed.is_lean).lower(),
        "serial": str(fixed.is_serial).lower(),
        "weight_bits": fixed.weight_bits,
        "turning": "".join(str(int(turns)) for turns in fixed.is_turning[::-1]),
        "phase_bits": q.PHASE_BITS,
        "step_bits": q.STEP_BITS,
        "steps_bits": fixed.n_axes * q.STEP_BITS - 1,
        "count_bits": q.COUNT_BITS,
        "force_bits": q.FORCE_BITS,
        "current_bits": q.CURRENT_BITS,
    }


def _scalars(fixed: FixedNetwork) -> dict:
    """Constants of each axis or input, and the widths of those side by side."""
    operands = ("current_scale", "input_scale", "x_low", "x_high", "output_scale")
    return {
        **{key: _packed(getattr(fixed, key), q.OPERAND_BITS) for key in operands},
        **{key: _packed(getattr(fixed, key), q.STEP_BITS) for key in ("coarse_step", "fine_step")},
        "count_low": _integers(fixed.count_low),
        "count_high": _integers(fixed.count_high),
        "input_scale_bits": fixed.n_axes * q.OPERAND_BITS - 1,
        "feature_bits": fixed.n_inputs * q.OPERAND_BITS - 1,
        "output_bias_bits": fixed.n_axes * fixed.output_sum_bits - 1,
        "output_bias": _packed(fixed.output_bias, fixed.output_sum_bits),
    }


def _weights(fixed: FixedNetwork) -> dict:
    """The words of both layers, one per neuron, and their widths."""
    hidden = [
        [(bias, fixed.hidden_sum_bits), *((weight, fixed.weight_bits) for weight in row[::-1])]
        for row, bias in zip(fixed.hidden_weights, fixed.hidden_bias, strict=True)
    ]
    output = [[(weight, fixed.weight_bits) for weight in column[::-1]] for column in fixed.output_weights.T]
    return {
        "hidden_word_bits": fixed.hidden_sum_bits + fixed.n_inputs * fixed.weight_bits,
        "output_word_bits": fixed.n_axes * fixed.weight_bits,
        "hidden_words": _words(hidden),
        "output_words": _words(output),
    }


def _places(fixed: FixedNetwork) -> dict:
    """Where the binary points are, what is dropped, and how wide sums are."""
    of_axes = ("count_shift", "input_scale_fraction", "output_scale_fraction", "current_scale_fraction")
    of_all = (
        "x_fraction", "weight_fraction", "hidden_product_drop", "hidden_sum_bits", "preactivation_drop",
        "output_weight_fraction", "output_product_drop", "output_sum_bits", "y_fraction", "y_bits", "output_drop",
    )  # fmt: skip
    return {
        **{key: _integers(getattr(fixed, key)) for key in of_axes},
        **{key: getattr(fixed, key) for key in of_all},
        "preactivation_fraction": q.PREACTIVATION_FRACTION,
        "slope_fraction": q.SLOPE_FRACTION,
        "hidden_fraction": q.HIDDEN_FRACTION,
    }


def _bits(value: int, width: int) -> str:
    return f"{int(value) & (2**width - 1):0{width}b}"


def _integers(values: np.ndarray) -> str:
    return ", ".join(f"{i} => {value}" for i, value in enumerate(values))


def _packed(values: np.ndarray, width: int) -> str:
    """One bit-string literal, first value lowest."""
    return 'b"' + "_".join(_bits(value, width) for value in values[::-1]) + '"'


def _words(rows: list[list[tuple[int, int]]]) -> str:
    lines = []
    for number, row in enumerate(rows):
        literal = "_".join(_bits(value, width) for value, width in row)
        comma = "," if number < len(rows) - 1 else " "
        lines.append(f'    {number:2d} => b"{literal}"{comma} -- {" ".join(str(int(value)) for value, _ in row)}')
    return "\n".join(lines)


_TEMPLATE = """\
-- SPDX-License-Identifier: MIT
--
-- Generated from weights/{name} by `make rom`; do not edit.
--
-- Codes are integers of value * 2**fraction. The biases hold the offsets of both normalisations and the half LSB of
-- every truncation.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

package gc_network_pkg is

  -- SHA-256 of all that this package and gc_compensation_pkg depend on: clock, axes and activation in robot.toml,
  -- hidden.csv, output.csv, scaling.csv, compensation.csv.
  constant weights_hash_c : std_ulogic_vector(255 downto 0) :=
    x"{sha256}";

  -- Hz of the core's clock: the tables of friction hold for this one.
  constant clock_hz_c : positive := {clock_hz};

  -- Sizes: axes, whose counts come in and efforts go out; what the hidden layer sees of them; hidden neurons.
  constant axes_c     : positive := {n_axes};
  constant inputs_c   : positive := axes_c;
  constant features_c : positive := {n_inputs};
  constant hidden_c   : positive := {n_hidden};
  constant outputs_c  : positive := axes_c;

  -- Widths of the ports.
  constant count_bits_c   : positive := {count_bits};
  constant force_bits_c   : positive := {force_bits};
  constant current_bits_c : positive := {current_bits};

  type counts_t is array (0 to inputs_c - 1) of integer;

  -- Bits, per axis.
  type axis_bits_t is array (0 to axes_c - 1) of natural;

  -- Input: clamp to the trained range (encoder counts), drop bits, scale to x.
  constant count_low_c            : counts_t := ({count_low});
  constant count_high_c           : counts_t := ({count_high});
  constant count_shift_c          : axis_bits_t := ({count_shift});
  constant input_scale_c          : signed({input_scale_bits} downto 0) :=
    {input_scale};
  constant input_scale_fraction_c : axis_bits_t := ({input_scale_fraction});
  constant x_fraction_c           : natural  := {x_fraction};

  -- x of the limits of the trained range.
  constant x_low_c  : signed({feature_bits} downto 0) :=
    {x_low};
  constant x_high_c : signed({feature_bits} downto 0) :=
    {x_high};

  -- Axes, axis 1 lowest, whose sine and cosine the hidden layer sees; turns per 2**16 counts and per count of them.
  constant turning_c     : std_ulogic_vector(inputs_c - 1 downto 0) := "{turning}";
  constant phase_bits_c  : positive := {phase_bits};
  constant step_bits_c   : positive := {step_bits};
  constant coarse_step_c : signed({steps_bits} downto 0) :=
    {coarse_step};
  constant fine_step_c   : signed({steps_bits} downto 0) :=
    {fine_step};

  -- The form: the paper's, or the lean one, whose scales are 1 as its weights hold them; the serial one is the lean one
  -- with weights of fewer bits, for gc_core_serial.
  constant lean_c        : boolean := {lean};
  constant serial_form_c : boolean := {serial};

  -- Hidden layer; product_drop: bits that a product loses before it is summed.
  constant weight_fraction_c        : natural  := {weight_fraction};
  constant hidden_product_drop_c    : natural  := {hidden_product_drop};
  constant hidden_sum_bits_c        : positive := {hidden_sum_bits};
  constant preactivation_fraction_c : natural  := {preactivation_fraction};
  constant preactivation_drop_c     : natural  := {preactivation_drop};
  constant slope_fraction_c         : natural  := {slope_fraction};
  constant hidden_fraction_c        : natural  := {hidden_fraction};

  -- Output layer.
  constant output_weight_fraction_c : integer  := {output_weight_fraction};
  constant output_product_drop_c    : natural  := {output_product_drop};
  constant output_sum_bits_c        : positive := {output_sum_bits};
  constant y_fraction_c             : natural  := {y_fraction};
  constant y_bits_c                 : positive := {y_bits};
  constant output_drop_c            : natural  := {output_drop};
  constant output_bias_c            : signed({output_bias_bits} downto 0) :=
    {output_bias};

  -- Output: scale y to mN or mNm, and that to uA by the 1/K_t of each axis.
  constant output_scale_c           : signed({input_scale_bits} downto 0) :=
    {output_scale};
  constant output_scale_fraction_c  : axis_bits_t := ({output_scale_fraction});
  constant current_scale_c          : signed({input_scale_bits} downto 0) :=
    {current_scale};
  constant current_scale_fraction_c : axis_bits_t := ({current_scale_fraction});

  -- Weights, and words of them, one per neuron.
  constant weight_bits_c      : positive := {weight_bits};
  constant hidden_word_bits_c : positive := {hidden_word_bits};
  constant output_word_bits_c : positive := {output_word_bits};

  subtype hidden_word_t is std_ulogic_vector(hidden_word_bits_c - 1 downto 0);

  subtype output_word_t is std_ulogic_vector(output_word_bits_c - 1 downto 0);

  type hidden_words_t is array (0 to hidden_c - 1) of hidden_word_t;

  type output_words_t is array (0 to hidden_c - 1) of output_word_t;

  -- bias, weights of the inputs from last to first
  constant hidden_words_c : hidden_words_t := (
{hidden_words}
  );

  -- weights of the outputs from last to first
  constant output_words_c : output_words_t := (
{output_words}
  );

  -- The tables as one vector, word 0 lowest.
  function flat (words : hidden_words_t) return std_ulogic_vector;

  function flat (words : output_words_t) return std_ulogic_vector;

  -- Counts as one vector, axis 1 lowest.
  function flat (counts : counts_t) return signed;

end package gc_network_pkg;

package body gc_network_pkg is

  function flat (words : hidden_words_t) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(hidden_c * hidden_word_bits_c - 1 downto 0);
  begin
    for i in words'range loop
      flat_v((i + 1) * hidden_word_bits_c - 1 downto i * hidden_word_bits_c) := words(i);
    end loop;
    return flat_v;
  end function flat;

  function flat (words : output_words_t) return std_ulogic_vector is
    variable flat_v : std_ulogic_vector(hidden_c * output_word_bits_c - 1 downto 0);
  begin
    for i in words'range loop
      flat_v((i + 1) * output_word_bits_c - 1 downto i * output_word_bits_c) := words(i);
    end loop;
    return flat_v;
  end function flat;

  function flat (counts : counts_t) return signed is
    variable flat_v : signed(inputs_c * count_bits_c - 1 downto 0);
  begin
    for i in counts'range loop
      flat_v((i + 1) * count_bits_c - 1 downto i * count_bits_c) := to_signed(counts(i), count_bits_c);
    end loop;
    return flat_v;
  end function flat;

end package body gc_network_pkg;
"""
