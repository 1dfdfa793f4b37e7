"""gravcomp.core.vhdl.small_registers: the registers read and write as PeakRDL's do, a clock later and in half of the
cells."""

from pathlib import Path

import pytest

from gravcomp.core.vhdl.registers import MOTION_REGISTERS, REGISTERS, peakrdl_files, register_files
from gravcomp.core.vhdl.small_registers import retimed, small
from gravcomp.errors import InputError
from gravcomp_lab.formal.model_check import differs_soon, same_at_ports, write_miter
from gravcomp_lab.synthesis.verilog import to_verilog
from runner import RTL

WRITTEN = """\
    signal rd_mux_addr : unsigned(11 downto 0);
            next_c := (field_storage.control.enable.value and not decoded_wr_biten(3)) or (decoded_wr_data(3) and decoded_wr_biten(3));
            next_c := (field_storage.limit(i0).value and not decoded_wr_biten(6 downto 4)) or (decoded_wr_data(6 downto 4) and decoded_wr_biten(6 downto 4));
            next_c := field_storage.status.value and not (decoded_wr_data(1) and decoded_wr_biten(1));
    rd_mux_addr <= unsigned(decoded_addr);
            if rd_mux_addr = 16#60# + i0 * 16#4# then
                readback_data_var(31 downto 0) := hwif_in.low(i0).next_q;
            end if;
            if rd_mux_addr = 16#8# then
                readback_data_var(3) := hwif_in.lean.next_q;
            end if;
"""  # noqa: E501, as PeakRDL writes it

DECODED = """\
    signal decoded_addr : std_logic_vector(11 downto 0);
    signal decoded_req : std_logic;
        s_axil_arready <= not axil_arvalid or axil_ar_accept;
    -- Address Decode
    -----
    process(all)
        variable is_valid_rw : std_logic;
    begin
        decoded_reg_strb.id <= cpuif_req_masked and (cpuif_addr = 16#0#) and not cpuif_req_is_wr;
        decoded_err <= not is_valid_rw and decoded_req;
    end process;

    -- Pass down signals to next stage
    process(all) begin
        decoded_addr <= cpuif_addr;
        decoded_req <= cpuif_req_masked;
    end process;

    -----
    -- Field logic
    process(all) begin
        next_c := cpuif_addr;
    end process;
"""


def test_a_request_is_decoded_a_clock_after_it_was_taken():
    lines = [line.strip() for line in retimed(DECODED).splitlines()]
    assert "decoded_reg_strb.id <= decoded_req and (decoded_addr = 16#0#) and not decoded_req_is_wr;" in lines
    at = lines.index("if rising_edge(clk) then")
    moves = ["decoded_addr <= cpuif_addr;", "decoded_req <= cpuif_req_masked and not rst;"]
    assert lines[at - 1 : at + 4] == ["process(clk) begin", lines[at], *moves, "end if;"]
    assert "next_c := cpuif_addr;" in lines


def test_no_request_is_taken_while_the_one_before_goes_on():
    assert "s_axil_arready <= not axil_arvalid;" in retimed(DECODED)


@pytest.mark.parametrize(
    ("part", "lack"),
    [
        ("Address Decode", "decodes no address"),
        ("Pass down", "decodes no address"),
        ("process(all) begin", "passes no request on"),
        ("arready", "takes no request"),
    ],
)
def test_another_form_is_not_retimed(part, lack):
    left = "\n".join(line for line in DECODED.splitlines() if part not in line)
    with pytest.raises(InputError, match=f"PeakRDL's VHDL {lack}"):
        retimed(left + "\n")


def test_masked_writes_become_enables_and_others_stay():
    lines = [line.strip() for line in small(WRITTEN).splitlines()]
    assert "if decoded_wr_biten(3) then next_c := decoded_wr_data(3); end if;" in lines
    bit = "if decoded_wr_biten(b) then next_c(b - 4) := decoded_wr_data(b); end if;"
    assert f"for b in 4 to 6 loop {bit} end loop;" in lines
    assert "next_c := field_storage.status.value and not (decoded_wr_data(1) and decoded_wr_biten(1));" in lines


def test_words_are_chosen_by_the_address_taken_and_ored():
    text = small(WRITTEN)
    assert "signal read_select : std_logic_vector(1023 downto 0) := (0 => '1', others => '0');" in text
    assert "if unsigned(axil_araddr(11 downto 2)) = i then" in text
    assert "if read_select((16#60# + i0 * 16#4#) / 4) then" in text
    assert "readback_data_var(31 downto 0) := readback_data_var(31 downto 0) or hwif_in.low(i0).next_q;" in text
    assert "readback_data_var(3) := readback_data_var(3) or hwif_in.lean.next_q;" in text
    assert "rd_mux_addr" not in text


@pytest.mark.parametrize(
    ("part", "lack"),
    [
        ("signal rd_mux_addr", "declares no address"),
        ("rd_mux_addr <=", "takes no address"),
        ("if rd_mux_addr", "chooses no word"),
        ("readback_data_var", "reads no word"),
        ("next_c", "writes no word"),
    ],
)
def test_another_form_is_refused(part, lack):
    left = "\n".join(line for line in WRITTEN.splitlines() if part not in line)
    with pytest.raises(InputError, match=f"PeakRDL's VHDL {lack}"):
        small(left + "\n")


def verilog_of(written: dict[str, str], entity: str, folder: Path) -> Path:
    """Verilog of registers as written."""
    folder.mkdir()
    sources = [RTL / "registers" / "reg_utils.vhd"]
    for name in (f"{entity}_pkg.vhd", f"{entity}.vhd"):
        sources.append(folder / name)
        sources[-1].write_text(written[name])
    return to_verilog(sources, entity, {}, folder / "registers.v")


def retimed_files(n_axes: int) -> dict[str, str]:
    """As PeakRDL writes them, but retimed."""
    written = peakrdl_files(n_axes)
    return {name: text if name.endswith("_pkg.vhd") else retimed(text) for name, text in written.items()}


@pytest.mark.slow
@pytest.mark.parametrize("entity", [REGISTERS, MOTION_REGISTERS])
def test_small_registers_are_proven_equal_at_their_ports(entity, tmp_path):
    """From power-up on, for anything on the bus and from the core, with one axis; what each bit reads as included."""
    gold, gate = (verilog_of(files(1), entity, tmp_path / files.__name__) for files in (retimed_files, register_files))
    assert same_at_ports(write_miter(gold, gate, entity, tmp_path, from_zero=True), 300)


@pytest.mark.slow
def test_planted_fault_is_no_equality(tmp_path):
    written, right = register_files(1), "if decoded_wr_biten(b) then next_c(b - 0) := decoded_wr_data(b)"
    wrong = {name: text.replace(right, right.replace("(b) then", "(31) then"), 1) for name, text in written.items()}
    assert wrong != written
    gold, gate = (
        verilog_of(of, MOTION_REGISTERS, tmp_path / name) for name, of in (("gold", written), ("gate", wrong))
    )
    assert differs_soon(write_miter(gold, gate, MOTION_REGISTERS, tmp_path, from_zero=True), 300)
