"""GHDL's library ieee with quicker bodies of the sums and products of numeric_std; what they return is the same.

The body of numeric_std that GHDL comes with adds bit by bit, with a call of "xor", "and" or "or" for each of seven
operations a bit, and multiplies by as many such sums as an operand has bits: a product of 18 x 24 takes some 40 us, and
a simulation of the core little else. Here a sum counts the bits of a place, and a product is one of limbs of 14 bits,
as integers hold. Both are reached behind the checks of the original, with operands of '0' and '1' only; all else is the
file that GHDL was installed with. A file that does not hold these functions as they are known is left as it is.
"""

import hashlib
import os
import re
import subprocess
import tempfile
from functools import cache
from pathlib import Path

from gravcomp.errors import InputError
from gravcomp.files import write_atomically

_FILES = ("std_logic_1164", "std_logic_1164-body", "numeric_std", "numeric_std-body", "math_real", "math_real-body")
_BODY = "numeric_std-body"

# Of operands of one length.
_SUM = """\
    constant L_LEFT : INTEGER := L'length-1;
    alias XL        : UNRESOLVED_{kind}(L_LEFT downto 0) is L;
    alias XR        : UNRESOLVED_{kind}(L_LEFT downto 0) is R;
    variable RESULT : UNRESOLVED_{kind}(L_LEFT downto 0);
    variable COUNT  : NATURAL := 0;
  begin
    if C = '1' then COUNT := 1;
    end if;
    for I in 0 to L_LEFT loop
      if XL(I) = '1' then COUNT := COUNT + 1;
      end if;
      if XR(I) = '1' then COUNT := COUNT + 1;
      end if;
      case COUNT is
        when 0 => RESULT(I) := '0';
        when 1 => RESULT(I) := '1'; COUNT := 0;
        when 2 => RESULT(I) := '0'; COUNT := 1;
        when others => RESULT(I) := '1'; COUNT := 1;
      end case;
    end loop;
    return RESULT;
"""

# Columns of the product in turn, each with what the ones before carry; the highest limb of an operand has its sign.
_PRODUCT = """\
  type LIMBS is array (NATURAL range <>) of INTEGER;

  function SPLIT (X : UNRESOLVED_SIGNED) return LIMBS is
    variable PARTS : LIMBS(0 to (X'length-1) / 14) := (others => 0);
  begin
    if X(X'left) = '1' then PARTS(PARTS'right) := -1;
    end if;
    for I in X'range loop
      PARTS(I / 14) := 2 * PARTS(I / 14);
      if X(I) = '1' then PARTS(I / 14) := PARTS(I / 14) + 1;
      end if;
    end loop;
    return PARTS;
  end function SPLIT;

  function MULTIPLY (XL, XR : UNRESOLVED_SIGNED) return UNRESOLVED_SIGNED is
    constant A      : LIMBS := SPLIT(XL);
    constant B      : LIMBS := SPLIT(XR);
    variable RESULT : UNRESOLVED_SIGNED(XL'length+XR'length-1 downto 0) := (others => '0');
    variable SUM    : INTEGER := 0;
    variable LIMB   : INTEGER;
    variable PLACE  : INTEGER;
  begin
    for K in 0 to (RESULT'length-1) / 14 loop
      for I in MAXIMUM(0, K - B'right) to MINIMUM(K, A'right) loop
        SUM := SUM + A(I) * B(K - I);
      end loop;
      LIMB  := SUM mod 16384;
      SUM   := (SUM - LIMB) / 16384;
      PLACE := 8192;
      for I in 14 * K + 13 downto 14 * K loop
        if LIMB >= PLACE then
          LIMB := LIMB - PLACE;
          if I < RESULT'length then RESULT(I) := '1';
          end if;
        end if;
        PLACE := PLACE / 2;
      end loop;
    end loop;
    return RESULT;
  end function MULTIPLY;

"""
# A column of seven products of limbs, and a carry, is an integer.
_MULTIPLIES = """\
    if XL'length <= 7 * 14 or XR'length <= 7 * 14 then return MULTIPLY(XL, XR);
    end if;
"""


def quick_ieee(folder: Path) -> list[str]:
    """Options of GHDL for its library ieee with quick sums and products, VHDL-2008, made in a folder of its content in
    this folder; none, for its own, where GHDL is of another kind than is known here."""
    if (known := _known()) is None:
        return []
    sources, body = known
    library = folder.absolute() / f"ieee-{hashlib.sha256((str(sources) + body).encode()).hexdigest()[:12]}"
    if not (library / "ieee-obj08.cf").exists():
        if not (library / f"{_BODY}.vhdl").exists():
            write_atomically(library / f"{_BODY}.vhdl", body)
        _analyse(sources, library)
    return ["--ieee=none", f"-P{library}"]


def quick_body(text: str) -> str | None:
    """The body of numeric_std with quick sums and products; None where they are not as they are known."""
    for kind in ("UNSIGNED", "SIGNED"):
        declared = r"    constant L_LEFT .*?"
        text, n = re.subn(
            rf"(  function ADD_{kind} \(L, R : UNRESOLVED_{kind}; C : STD_LOGIC\)\s+return UNRESOLVED_{kind}\s+is\n)"
            rf"{declared}(  end function ADD_{kind};)",
            lambda found, kind=kind: found[1] + _SUM.format(kind=kind) + found[2],
            text,
            flags=re.DOTALL,
        )
        if n != 1:
            return None
    head = r'  function "\*" \(L, R : UNRESOLVED_SIGNED\) return UNRESOLVED_SIGNED is'
    text, n = re.subn(
        rf"({head}(?:(?!end function).)*?)(    ADVAL :=)",
        lambda found: _PRODUCT + found[1] + _MULTIPLIES + found[2],
        text,
        flags=re.DOTALL,
    )
    return text if n == 1 else None


@cache
def _known() -> tuple[Path, str] | None:
    """The folder of the sources of ieee that GHDL on the path was installed with, and its quick body of numeric_std.

    None where that cannot be had. GHDL that compiles to files would need those of ieee, too: they are not made.
    """
    try:
        said = "".join(
            subprocess.run(["ghdl", option], capture_output=True, text=True, check=False).stdout
            for option in ("--version", "--disp-config")
        )
    except FileNotFoundError:
        return None
    found = re.search(r"^library directory: (.+)$", said, re.MULTILINE)
    if found is None or "mcode code generator" not in said:
        return None
    sources = Path(found[1]) / "src" / "ieee2008"
    if not all((sources / f"{name}.vhdl").is_file() for name in _FILES):
        return None
    body = quick_body((sources / f"{_BODY}.vhdl").read_text())
    return body and (sources, body)


def _analyse(sources: Path, library: Path) -> None:
    """Make the library beside the body in it; InputError when GHDL refuses."""
    paths = [(library if name == _BODY else sources) / f"{name}.vhdl" for name in _FILES]
    with tempfile.TemporaryDirectory(dir=library) as made:
        command = ["ghdl", "-a", "--std=08", "--ieee=none", "--work=ieee", f"--workdir={made}", *map(str, paths)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            raise InputError(f"{library}: GHDL refuses its own library\n{done.stderr}")
        os.replace(Path(made) / "ieee-obj08.cf", library / "ieee-obj08.cf")
