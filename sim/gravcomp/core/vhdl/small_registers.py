"""VHDL of registers as PeakRDL writes it, for fewer cells and shorter paths.

retimed answers a clock later: a register stands between what chooses among reads and writes and the decoding of their
addresses, and no request is taken in the clock in which the one before it goes on. PeakRDL's own settings retime what
is read only, and the way of a write is the longer one.

small answers the same in the same clock as what retimed writes:

* a word that is read is chosen by a flip-flop of its own, set when its address is decoded, and the words are ORed. As
  written, its address is compared in a chain of multiplexers, which synthesis makes part of the cone of every bit.
* a byte that is written is enabled as its flip-flops are. As written, every bit has a gate that puts its value back.
"""

import re

from gravcomp.errors import InputError

_DECLARED = re.compile(r"    signal rd_mux_addr : unsigned\((\d+) downto 0\);\n")
_ADDRESS = re.compile(r"    rd_mux_addr <= unsigned\(decoded_addr\);\n")
_CHOSEN = re.compile(r"if rd_mux_addr = (.+?) then")
_READ = re.compile(r"(readback_data_var\(.+?\)) := (?=\S)")
_WRITTEN = re.compile(
    r"next_c := \(field_storage\.\S+ and not decoded_wr_biten\((.+?)\)\)"
    r" or \(decoded_wr_data\(\1\) and decoded_wr_biten\(\1\)\);"
)
_DECODED = re.compile(r"    -- Address Decode\n    -.*?(?=    -- Pass down signals to next stage\n)", re.DOTALL)
_PASSED = re.compile(r"    process\(all\) begin\n((?:        decoded_\w+ <= \w+;\n)+)    end process;\n")
_READY = re.compile(r"(s_axil_\w+ready <= not axil_\w+) or axil_\w+_accept;")
_REQUEST = "decoded_req <= cpuif_req_masked;"
_NOT_IN_RESET = "decoded_req <= cpuif_req_masked and not rst;"
# Of a request, as it is chosen and a clock later.
_LATER = {
    "cpuif_req_masked": "decoded_req",
    "cpuif_req_is_wr": "decoded_req_is_wr",
    "cpuif_addr": "decoded_addr",
}
_SELECT = "    signal read_select : std_logic_vector({last} downto 0) := (0 => '1', others => '0');\n"
_CHOICE = """\
    process(clk) begin
        if rising_edge(clk) then
            for i in read_select'range loop
                if unsigned(axil_araddr({high} downto 2)) = i then
                    read_select(i) <= '1';
                else
                    read_select(i) <= '0';
                end if;
            end loop;
        end if;
    end process;
"""


def retimed(text: str) -> str:
    """The same registers, a clock later. Raises InputError when a part of the text is not of the form that is known."""
    decoded = _found("decodes no address", _DECODED, text)[0]
    passed = _found("passes no request on", _PASSED, text)
    _found("takes no request", _READY, text)
    later = re.sub("|".join(_LATER), lambda found: _LATER[found[0]], decoded)
    moves = "".join(f"    {line}\n" for line in passed[1].replace(_REQUEST, _NOT_IN_RESET).splitlines())
    clocked = f"    process(clk) begin\n        if rising_edge(clk) then\n{moves}        end if;\n    end process;\n"
    return _READY.sub(r"\1;", text.replace(decoded, later).replace(passed[0], clocked))


def small(text: str) -> str:
    """The same registers, smaller. Raises InputError when a part of the text is not of the form that is known."""
    high = int(_found("declares no address", _DECLARED, text)[1])
    forms = (
        ("declares no address", _DECLARED, _SELECT.format(last=2 ** (high - 1) - 1)),
        ("takes no address", _ADDRESS, _CHOICE.format(high=high)),
        ("chooses no word", _CHOSEN, r"if read_select((\1) / 4) then"),
        ("reads no word", _READ, r"\1 := \1 or "),
        ("writes no word", _WRITTEN, _enabled),
    )
    for lack, pattern, form in forms:
        _found(lack, pattern, text)
        text = pattern.sub(form, text)
    return text


def _found(lack: str, pattern: re.Pattern, text: str) -> re.Match:
    if not (found := pattern.search(text)):
        raise InputError(f"PeakRDL's VHDL {lack} in the form that is known; install the version that is pinned")
    return found


def _enabled(found: re.Match) -> str:
    bits = found[1]
    if " downto " not in bits:
        return f"if decoded_wr_biten({bits}) then next_c := decoded_wr_data({bits}); end if;"
    high, low = bits.split(" downto ")
    write = f"if decoded_wr_biten(b) then next_c(b - {low}) := decoded_wr_data(b); end if;"
    return f"for b in {low} to {high} loop {write} end loop;"
