"""GHDL's library ieee with a quicker body of numeric_std; what its functions return is the same.

The body of numeric_std that GHDL comes with copies each operand four times before it looks at a bit, adds bit by bit
with a call of "xor", "and" or "or" for each of seven operations, and multiplies by as many such sums as an operand has
bits: a product of 18 x 24 takes some 40 us, a sum of 32 bits 3 us, and a simulation of the core little else. Here each
function begins with a shortcut for what hardware computes with nearly always, operands of one length that hold '0' and
'1' only; behind it all is the file that GHDL was installed with. A file that does not hold these functions as they are
known is left as it is.
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

# Ahead of all functions of the body.
_HELPERS = """\
  function IS_01 (X : STD_ULOGIC_VECTOR) return BOOLEAN is
  begin
    for I in X'range loop
      case X(I) is
        when '0' | '1' => null;
        when others    => return false;
      end case;
    end loop;
    return true;
  end function IS_01;

  function PLAIN (L, R : STD_ULOGIC_VECTOR) return BOOLEAN is
  begin
    return L'length = R'length and L'length > 0 and IS_01(L) and IS_01(R);
  end function PLAIN;

  function FROM_RIGHT (X : STD_ULOGIC_VECTOR) return STD_ULOGIC_VECTOR is
    alias RESULT : STD_ULOGIC_VECTOR(X'length-1 downto 0) is X;
  begin
    return RESULT;
  end function FROM_RIGHT;

  -- L + R, or with MINUS = '1' L - R.
  function ADDED (L, R : STD_ULOGIC_VECTOR; MINUS : STD_ULOGIC) return STD_ULOGIC_VECTOR is
    alias XL        : STD_ULOGIC_VECTOR(L'length-1 downto 0) is L;
    alias XR        : STD_ULOGIC_VECTOR(L'length-1 downto 0) is R;
    variable RESULT : STD_ULOGIC_VECTOR(L'length-1 downto 0);
    variable CBIT   : STD_ULOGIC := MINUS;
  begin
    for I in 0 to RESULT'left loop
      if (XL(I) = XR(I)) = (MINUS = '0') then
        RESULT(I) := CBIT;
        CBIT      := XL(I);
      elsif CBIT = '1' then RESULT(I) := '0';
      else RESULT(I) := '1';
      end if;
    end loop;
    return RESULT;
  end function ADDED;

  -- SIGN: 0, or -1 where X is negative.
  function WHOLE (X : STD_ULOGIC_VECTOR; SIGN : INTEGER) return INTEGER is
    variable RESULT : INTEGER := SIGN;
  begin
    for I in X'range loop
      RESULT := RESULT + RESULT;
      if X(I) = '1' then RESULT := RESULT + 1;
      end if;
    end loop;
    return RESULT;
  end function WHOLE;

  function SIGN (X : STD_ULOGIC_VECTOR) return INTEGER is
  begin
    if X(X'left) = '1' then return -1;
    end if;
    return 0;
  end function SIGN;

  type LIMBS is array (NATURAL range <>) of INTEGER;

  -- 14 bits each; the highest one has the sign.
  function SPLIT (X : STD_ULOGIC_VECTOR) return LIMBS is
    alias XX       : STD_ULOGIC_VECTOR(X'length-1 downto 0) is X;
    variable PARTS : LIMBS(0 to (X'length-1) / 14);
  begin
    for K in 0 to PARTS'right-1 loop
      PARTS(K) := WHOLE(XX(14 * K + 13 downto 14 * K), 0);
    end loop;
    PARTS(PARTS'right) := WHOLE(XX(XX'left downto 14 * PARTS'right), SIGN(XX));
    return PARTS;
  end function SPLIT;

  -- Columns of the product in turn, each with what the ones before carry.
  function MULTIPLY (XL, XR : UNRESOLVED_SIGNED) return UNRESOLVED_SIGNED is
    constant A      : LIMBS := SPLIT(STD_ULOGIC_VECTOR(XL));
    constant B      : LIMBS := SPLIT(STD_ULOGIC_VECTOR(XR));
    variable RESULT : UNRESOLVED_SIGNED(XL'length+XR'length-1 downto 0);
    variable SUM    : INTEGER := 0;
    variable LIMB   : INTEGER;
  begin
    for K in 0 to (RESULT'length-1) / 14 loop
      for I in MAXIMUM(0, K - B'right) to MINIMUM(K, A'right) loop
        SUM := SUM + A(I) * B(K - I);
      end loop;
      LIMB := SUM mod 16384;
      SUM  := (SUM - LIMB) / 16384;
      for I in 14 * K to MINIMUM(14 * K + 13, RESULT'left) loop
        if LIMB mod 2 = 1 then RESULT(I) := '1';
        else RESULT(I) := '0';
        end if;
        LIMB := LIMB / 2;
      end loop;
    end loop;
    return RESULT;
  end function MULTIPLY;

"""
_BEFORE_HELPERS = "  -- this internal function computes the addition of two UNRESOLVED_UNSIGNED\n"


def _vector(name: str) -> str:
    return f"STD_ULOGIC_VECTOR({name})"


def _shortcuts() -> dict[str, tuple[str, str]]:
    """By head of a function: when its shortcut is taken, and the statements of it."""
    return {
        head: shortcut
        for kind in ("UNSIGNED", "SIGNED")
        for head, shortcut in (_arithmetic(kind) | _comparisons(kind) | _conversions(kind)).items()
    } | {
        '"-" (ARG : UNRESOLVED_SIGNED) return UNRESOLVED_SIGNED': (
            f"ARG'length > 0 and IS_01({_vector('ARG')})",
            f"return UNRESOLVED_SIGNED(ADDED((ARG'length-1 downto 0 => '0'), {_vector('ARG')}, '1'));",
        ),
        # A column of seven products of limbs, and a carry, is an integer.
        '"*" (L, R : UNRESOLVED_SIGNED) return UNRESOLVED_SIGNED': (
            f"L'length > 0 and R'length > 0 and MINIMUM(L'length, R'length) <= 7 * 14\n"
            f"      and IS_01({_vector('L')}) and IS_01({_vector('R')})",
            "return MULTIPLY(L, R);",
        ),
    }


def _arithmetic(kind: str) -> dict[str, tuple[str, str]]:
    return {
        f'"{sign}" (L, R : UNRESOLVED_{kind}) return UNRESOLVED_{kind}': (
            f"PLAIN({_vector('L')}, {_vector('R')})",
            f"return UNRESOLVED_{kind}(ADDED({_vector('L')}, {_vector('R')}, {minus}));",
        )
        for sign, minus in (("+", "'0'"), ("-", "'1'"))
    }


def _comparisons(kind: str) -> dict[str, tuple[str, str]]:
    """Of vectors of one length as of their bits from the left on, and of what an integer holds with an integer."""
    integer, bits, sign = ("NATURAL", 31, "0") if kind == "UNSIGNED" else ("INTEGER", 32, "SIGN({})")
    found = {}
    for relation in ("<", ">", "<=", ">=", "=", "/="):
        same = f"return {_vector('L')} {relation} {_vector('R')};"
        if kind == "SIGNED" and relation not in ("=", "/="):
            negative = "L(L'left)" if relation.startswith("<") else "R(R'left)"
            same = f"if L(L'left) /= R(R'left) then return {negative} = '1';\n      end if;\n      {same}"
        head = f'"{relation}" ({{}}) return BOOLEAN'
        found[head.format(f"L, R : UNRESOLVED_{kind}")] = f"PLAIN({_vector('L')}, {_vector('R')})", same
        for vector, l_type, r_type in (("R", integer, f"UNRESOLVED_{kind}"), ("L", f"UNRESOLVED_{kind}", integer)):
            value = f"WHOLE({_vector(vector)}, {sign.format(_vector(vector))})"
            compared = f"L {relation} {value}" if vector == "R" else f"{value} {relation} R"
            found[head.format(f"L : {l_type}; R : {r_type}")] = (
                f"{vector}'length > 0 and {vector}'length <= {bits} and IS_01({_vector(vector)})",
                f"return {compared};",
            )
    return found


def _conversions(kind: str) -> dict[str, tuple[str, str]]:
    integer, bits, sign = ("NATURAL", 31, "0") if kind == "UNSIGNED" else ("INTEGER", 32, f"SIGN({_vector('ARG')})")
    return {
        f"TO_INTEGER (ARG : UNRESOLVED_{kind}) return {integer}": (
            f"ARG'length > 0 and ARG'length <= {bits} and IS_01({_vector('ARG')})",
            f"return WHOLE({_vector('ARG')}, {sign});",
        ),
        f"TO_01 (S : UNRESOLVED_{kind}; XMAP : STD_ULOGIC := '0') return UNRESOLVED_{kind}": (
            f"S'length > 0 and IS_01({_vector('S')})",
            f"return UNRESOLVED_{kind}(FROM_RIGHT({_vector('S')}));",
        ),
        f"RESIZE (ARG : UNRESOLVED_{kind}; NEW_SIZE : NATURAL) return UNRESOLVED_{kind}": (
            "ARG'length > 0 and ARG'length = NEW_SIZE",
            f"return UNRESOLVED_{kind}(FROM_RIGHT({_vector('ARG')}));",
        ),
    }


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
    """The body of numeric_std with its shortcuts; None where a function is not as it is known."""
    if text.count(_BEFORE_HELPERS) != 1:
        return None
    text = text.replace(_BEFORE_HELPERS, _HELPERS + _BEFORE_HELPERS)
    for head, (taken, statements) in _shortcuts().items():
        written = r"\s+".join(map(re.escape, head.split()))
        inserted = f"    if {taken} then\n      {statements}\n    end if;\n"
        pattern = rf"(^  function {written}\s+is\n(?:    .*\n)*?  begin\n)"
        text, n = re.subn(pattern, lambda found, inserted=inserted: found[1] + inserted, text, flags=re.MULTILINE)
        if n != 1:
            return None
    return text


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
