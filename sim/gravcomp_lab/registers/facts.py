"""Facts of rtl/registers/facts.toml and of the register map, written for each language; `make regs` calls this.

``python -m gravcomp_lab.registers.facts FOLDER OUT`` reads facts.toml of this tree and the registers' IP-XACT in a
folder, and writes gc_facts_pkg.vhd, gc_scalars_pkg.vhd, gravcomp_facts.h, facts.py and the table in
docs/guide/system.md below OUT.
"""

import sys
import tomllib
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from gravcomp.driver.registers import REGISTERS_XML, Register, read_registers
from gravcomp.errors import InputError
from gravcomp.files import write_all_atomically
from gravcomp_lab.pages import renewed

ROOT = Path(__file__).resolve().parents[3]
SOURCE = ROOT / "rtl" / "registers" / "facts.toml"
PAGE = Path("docs/guide/system.md")
_ARRAYS = ("count", "phase_step")  # scalars that the ROM packages hold as arrays of integers


@dataclass(frozen=True)
class Facts:
    """facts.toml and the register map."""

    table: dict
    registers: dict[str, Register]

    @property
    def axes(self) -> int:
        """The most that a core can have: the map is theirs."""
        return self.registers["position"].count

    @cached_property
    def causes(self) -> dict[str, int]:
        """Bit of each cause."""
        return {name: low for name, (low, _) in self.registers["fault"].fields.items() if name != "clear"}

    @property
    def always(self) -> int:
        return sum(1 << self.causes[name] for name in self.table["always"])

    @property
    def load_key(self) -> int:
        return int.from_bytes(self.table["load_key"].encode("ascii"), "big")

    @property
    def guarded_block(self) -> int:
        """Address of the registers that the key guards, in blocks of 16 bytes. InputError unless they fill one."""
        blocks = {self.registers[name].address >> 4 for name in self.table["guarded"]}
        inside = {name for name, register in self.registers.items() if register.address >> 4 in blocks}
        if len(blocks) != 1 or inside != set(self.table["guarded"]):
            raise InputError(
                f"{SOURCE}: guarded: they must be alone in one block of 16 bytes; {sorted(inside)} are there"
            )
        return blocks.pop()

    @property
    def scalars(self) -> list[tuple[str, str, str]]:
        """Scalars of an image in order: name, of which there is one each, name of their width."""
        image = self.table["image"]
        return [(name, per, bits) for per in ("inputs", "features", "outputs") for name, bits in image[per].items()]


def files(facts: Facts) -> dict[Path, str]:
    """Text of each generated file, by its place in the tree."""
    return {
        Path("rtl/registers/gc_facts_pkg.vhd"): vhdl(facts),
        Path("rtl/registers/gc_scalars_pkg.vhd"): vhdl_scalars(facts),
        Path("host/gravcomp_facts.h"): c_header(facts),
        Path("sim/gravcomp/facts.py"): python(facts),
    }


def vhdl(facts: Facts) -> str:
    """gc_facts_pkg: what needs no network."""
    table = facts.table
    names, n_causes = table["image"]["sections"], len(facts.causes)
    sections = {f"{name}_section": k for k, name in enumerate(names)}
    return _VHDL.format(
        states=_constants("safety_state_t", {f"state_{name}": f'"{n:03b}"' for name, n in table["states"].items()}),
        causes=_constants("natural", {f"cause_{name}": bit for name, bit in facts.causes.items()}),
        n_causes=n_causes,
        always=f"{facts.always:0{n_causes}b}",
        key=f"{facts.load_key:08X}",
        block=f"{facts.guarded_block:02X}",
        window=table["record_window"],
        bits=_constants("positive", {f"{name}_bits": n for name, n in table["bits"].items()}),
        clocks=_constants("positive", {f"{name}_clocks": n for name, n in table["clocks"].items()}),
        sections=_constants("natural", {**sections, "sections": len(names)}),
    )


def vhdl_scalars(facts: Facts) -> str:
    """gc_scalars_pkg: the record of the scalars, for the network of the ROM."""
    scalars = facts.scalars
    return _VHDL_SCALARS.format(
        fields="\n".join(
            f"    {name:13} : signed({per}_c * {bits}_bits_c - 1 downto 0);" for name, per, bits in scalars
        ),
        width="\n    + ".join(f"{per}_c * {bits}_bits_c" for _, per, bits in scalars),
        rom=",\n".join(
            f"    {name:13} => " + (f"flat({name}_c)" if bits in _ARRAYS else f"{name}_c") for name, _, bits in scalars
        ),
        takes="\n".join(f"    take(scalars_v.{name});" for name, _, _ in scalars),
    )


def c_header(facts: Facts) -> str:
    # GRAVCOMP_FAULT is a result of the driver.
    names = {name: "FAULTED" if name == "fault" else name.upper() for name in facts.table["states"]}
    states = [f"    GRAVCOMP_{names[name]} = {code}" for name, code in facts.table["states"].items()]
    events = [
        f"#define GRAVCOMP_ON_{name.upper()} {1 << low}u"
        for name, (low, _) in facts.registers["interrupt_enable"].fields.items()
    ]
    return _C.format(
        axes=facts.axes,
        states=",\n".join(states),
        events="\n".join(events),
        key=f"0x{facts.load_key:08X}u",
        words=facts.table["words_per_kick"],
        window=facts.table["record_window"],
    )


def python(facts: Facts) -> str:
    table = facts.table
    events = facts.registers["interrupt_enable"].fields
    return _PYTHON.format(
        axes=facts.axes,
        key=f"0x{facts.load_key:08X}",
        words=table["words_per_kick"],
        window=table["record_window"],
        states="\n".join(f"    {name.upper()} = {code}" for name, code in table["states"].items()),
        causes="\n".join(f"    {name.upper()} = {bit}" for name, bit in facts.causes.items()),
        events="\n".join(f"    {name.upper()} = {1 << low}" for name, (low, _) in events.items()),
        always=f"0x{facts.always:04X}",
        bits="\n".join(f"{name.upper()}_BITS = {n}" for name, n in table["bits"].items()),
        clocks="\n".join(f"{name.upper()}_CLOCKS = {n}" for name, n in table["clocks"].items()),
        sections=", ".join(f'"{name}"' for name in table["image"]["sections"]),
        scalars="\n".join(f'    "{name}": "{bits}",' for name, _, bits in facts.scalars),
    )


def markdown(facts: Facts) -> str:
    """The same for a reader."""
    table, block = facts.table, facts.guarded_block
    rows = {
        "axes, at most": facts.axes,
        "states of the brakes (`status`)": _listed(table["states"], "{1} {0}"),
        "causes of a fault, bit by bit": _listed(facts.causes, "{1} `{0}`"),
        "key to loading": f"0x{facts.load_key:08X}, ASCII {table['load_key']}",
        "registers that it guards": f"0x{block << 4:03X} to 0x{(block << 4) + 15:03X}",
        "words of an image from kick to kick": table["words_per_kick"],
        "words of records that can be read at once": table["record_window"],
        "bits": _listed(table["bits"], "{0} {1}"),
        "clocks from in_valid to out_valid": _listed(table["clocks"], "`gc_{0}` {1}"),
        "sections of an image": ", ".join(table["image"]["sections"]),
        "scalars of its last section, per axis, `x_` per input of the network, and their bits": _listed(
            {name: bits for name, _, bits in facts.scalars}, "`{0}` {1}"
        ),
    }
    return "| fact | |\n|---|---|\n" + "".join(f"| {name} | {value} |\n" for name, value in rows.items()).replace(
        "_bits", ""
    )


def _listed(values: dict, form: str) -> str:
    return ", ".join(form.format(name, value) for name, value in values.items())


def _constants(kind: str, values: dict) -> str:
    """VHDL constants of one type, <name>_c each."""
    width = max(map(len, values)) + 2
    return "\n".join(f"  constant {name + '_c':{width}} : {kind} := {value};" for name, value in values.items())


_VHDL = """\
-- SPDX-License-Identifier: MIT
--
-- Written by `make regs` from facts.toml and gc_registers.rdl, which say what each is; do not edit.

library ieee;
  use ieee.std_logic_1164.all;

package gc_facts_pkg is

  -- States of the brakes.

  subtype safety_state_t is std_ulogic_vector(2 downto 0);

{states}

  -- Causes, bit by bit; docs/guide/safety.md says when each is present.
  constant causes_c : positive := {n_causes};
{causes}

  subtype causes_t is std_ulogic_vector(causes_c - 1 downto 0);

  constant no_causes_c : causes_t := (others => '0');

  -- Causes that are faults while braked, too.
  constant always_causes_c : causes_t := "{always}";

  -- Loading: the key, and the registers that it guards, in blocks of 16 bytes.
  constant load_key_c   : std_ulogic_vector(31 downto 0) := x"{key}";
  constant load_block_c : std_ulogic_vector(11 downto 4) := x"{block}";

  -- Words of records that the host can read at once.
  constant record_window_c : positive := {window};

{bits}

  -- Latencies.
{clocks}

  -- Sections of an image.
{sections}

end package gc_facts_pkg;
"""

_VHDL_SCALARS = """\
-- SPDX-License-Identifier: MIT
--
-- What is not in a table; axis 1 lowest. Written by `make regs` from facts.toml; do not edit.

library ieee;
  use ieee.std_logic_1164.all;
  use ieee.numeric_std.all;

library work;
  use work.gc_compensation_pkg.all;
  use work.gc_facts_pkg.all;
  use work.gc_network_pkg.all;

package gc_scalars_pkg is

  type scalars_t is record
{fields}
  end record scalars_t;

  constant scalar_bits_c : positive :=
    {width};

  constant rom_scalars_c : scalars_t := (
{rom}
  );

  -- The scalars of their record, fields from bit 0 upwards.
  function scalars_of (
    bits : std_ulogic_vector(scalar_bits_c - 1 downto 0)
  ) return scalars_t;

end package gc_scalars_pkg;

package body gc_scalars_pkg is

  function scalars_of (
    bits : std_ulogic_vector(scalar_bits_c - 1 downto 0)
  ) return scalars_t is

    variable scalars_v : scalars_t;
    variable low_v     : natural := 0;

    -- The next field.
    procedure take (
      variable field_v : out signed
    ) is
    begin
      field_v := signed(bits(low_v + field_v'length - 1 downto low_v));
      low_v := low_v + field_v'length;
    end procedure take;

  begin
{takes}
    return scalars_v;
  end function scalars_of;

end package body gc_scalars_pkg;
"""

_C = """\
/* SPDX-License-Identifier: MIT
 *
 * Written by `make regs` from rtl/registers/facts.toml and gc_registers.rdl; do not edit.
 */
#ifndef GRAVCOMP_FACTS_H
#define GRAVCOMP_FACTS_H

#define GRAVCOMP_MAX_AXES {axes}

/* States of the brakes. */
typedef enum {{
{states}
}} gravcomp_brakes;

/* Interrupts, to be combined. */
{events}

/* Loading: the key, and words from kick to kick. */
#define GRAVCOMP_LOAD_KEY {key}
#define GRAVCOMP_WORDS_PER_KICK {words}u

/* Words of records that can be read at once, from record_word on. */
#define GRAVCOMP_RECORD_WINDOW {window}u

#endif
"""

_PYTHON = '''\
"""Facts that VHDL and C have, too. Written by `make regs` from rtl/registers, facts.toml and gc_registers.rdl."""

from enum import IntEnum, IntFlag

MAX_AXES = {axes}

# Loading: the key, and words of an image from kick to kick.
LOAD_KEY = {key}
WORDS_PER_KICK = {words}

# Words of records that can be read at once, from record_word on.
RECORD_WINDOW = {window}


class State(IntEnum):
    """States of the brakes."""

{states}
    FAULTED = FAULT  # as in C, where GRAVCOMP_FAULT is a result


class Cause(IntEnum):
    """Causes of a fault, bits of the register fault."""

{causes}

    @property
    def mask(self) -> int:
        """The cause in a register of causes."""
        return 1 << self


# Causes that are faults while braked, too.
ALWAYS = {always}


class Event(IntFlag):
    """What interrupts."""

{events}


{bits}

# Latencies.
{clocks}

# An image: its sections, and the scalars of the last one with the name of their width.
IMAGE_SECTIONS = ({sections})
IMAGE_SCALARS = {{
{scalars}
}}
'''


def main(registers: Path, out: Path) -> None:
    facts = Facts(tomllib.loads(SOURCE.read_text()), read_registers(registers / REGISTERS_XML.name))
    texts = {out / place: text for place, text in files(facts).items()}
    texts[out / PAGE] = renewed((ROOT / PAGE).read_text(), "facts", markdown(facts), PAGE)
    write_all_atomically(texts)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
