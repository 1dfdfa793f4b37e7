"""Import into vendor tools: the Tcl scripts against stubs of the vendors' commands, FuseSoC on GHDL, constraints.

The vendors' tools themselves are not run.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from codes import fixed_network
from gravcomp import __version__
from gravcomp.twin.network import core
from gravcomp_lab.synthesis.verilog import source_of
from runner import ROOT, RTL, rtl_sources

TOPS = ("gc_force_path", "gc_system", "gc_serial_system")
SOURCES = [str(path) for path in rtl_sources()]


def tclsh(script: str, *arguments: str, cwd: Path = ROOT) -> list[list[str]]:
    """Words of each line that a script of tb/tcl prints; AssertionError with Tcl's message when it fails."""
    done = subprocess.run(["tclsh", ROOT / "tb/tcl" / script, *arguments], cwd=cwd, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return [line.split("\t") for line in done.stdout.splitlines()]


def run_import(vendor: str, tmp_path: Path, *arguments: str, root: Path = ROOT) -> list[list[str]]:
    script = str(root / "scripts" / f"{vendor}_import.tcl")
    return tclsh("vendor.tcl", vendor, script, f"out={tmp_path}", *arguments, cwd=tmp_path)


@pytest.mark.parametrize("top", TOPS)
def test_vivado_import_makes_the_project(top, tmp_path):
    calls = run_import("vivado", tmp_path, f"top={top}", "part=xc7z020clg400-1", "lanes_g=5", "filter_samples_g=2")
    assert calls[0] == ["create_project", "-force", "gravcomp", str(tmp_path), "-part", "xc7z020clg400-1"]
    assert ["add_files", "-norecurse", " ".join(SOURCES)] in calls
    assert ["set_property", "library", "gravcomp", " ".join(SOURCES)] in calls
    assert ["set_property", "file_type", "VHDL 2008", " ".join(SOURCES)] in calls
    assert ["add_files", "-fileset", "constrs_1", "-norecurse", str(ROOT / "constraints" / f"{top}.xdc")] in calls
    assert ["set_property", "top", top, "sources_1"] in calls
    assert ["set_property", "generic", "lanes_g=5 filter_samples_g=2", "sources_1"] in calls


@pytest.mark.parametrize("top", TOPS)
def test_quartus_import_makes_the_project(top, tmp_path):
    calls = run_import("quartus", tmp_path, f"top={top}", "part=10CX220YF780I5G", "lanes_g=5")
    assignments = [call[1:] for call in calls if call[0] == "set_global_assignment"]
    files = [words[2] for words in assignments if words[1] == "VHDL_FILE"]
    assert files == SOURCES
    assert all(words[3:] == ["-library", "gravcomp", "-hdl_version", "VHDL_2008"] for words in assignments if
               words[1] == "VHDL_FILE")  # fmt: skip
    assert ["-name", "DEVICE", "10CX220YF780I5G"] in assignments
    assert ["-name", "TOP_LEVEL_ENTITY", top] in assignments
    assert ["-name", "SDC_FILE", str(ROOT / "constraints" / f"{top}.sdc")] in assignments
    assert ["set_parameter", "-name", "lanes_g", "5"] in calls
    assert [call[0] for call in calls[-2:]] == ["export_assignments", "project_close"]


@pytest.mark.parametrize("top", TOPS)
def test_radiant_import_makes_the_project(top, tmp_path):
    calls = run_import("radiant", tmp_path, f"top={top}", "part=LFCPNX-100-9LFG672C", "lanes_g=5", "speed_timeout_g=9")
    added = [call[1:] for call in calls if call[0] == "prj_add_source"]
    assert added[:-1] == [[path, "-work", "work"] for path in SOURCES]
    assert added[-1] == [str(ROOT / "constraints" / f"{top}.sdc")]
    assert "LFCPNX-100-9LFG672C" in calls[0]
    assert ["prj_set_strategy_value", "-strategy", "Strategy1", "syn_vhdl2008=True"] in calls
    assert ["prj_set_impl_opt", "-impl", "impl_1", "top", top] in calls
    assert ["prj_set_impl_opt", "-impl", "impl_1", "HDL_PARAM", "lanes_g=5;speed_timeout_g=9"] in calls
    assert [call[0] for call in calls[-2:]] == ["prj_save", "prj_close"]


@pytest.mark.parametrize("vendor", ["vivado", "quartus", "radiant"])
@pytest.mark.parametrize(
    ("argument", "message"),
    [
        ("top=gc_toop", "no entity gc_toop"),
        ("lane_g=4", "gc_force_path has no generic lane_g"),
        ("pin_a=4", "gc_force_path has no generic pin_a"),
        ("gc_force_path", "need arguments NAME=VALUE, got gc_force_path"),
    ],
    ids=lambda value: str(value).replace(" ", "_"),
)
def test_import_refuses_wrong_arguments(vendor, argument, message, tmp_path):
    with pytest.raises(AssertionError, match=message):
        run_import(vendor, tmp_path, argument)


@pytest.mark.parametrize("vendor", ["vivado", "quartus", "radiant"])
@pytest.mark.parametrize("fault", ["source", "command"])
def test_stubs_refuse_what_the_vendor_would(vendor, fault, tmp_path):
    """A source that sources.f names but is not there; a command that the vendor does not have."""
    copy = tmp_path / "copy"
    for folder in ("rtl", "scripts", "constraints"):
        shutil.copytree(ROOT / folder, copy / folder)
    if fault == "source":
        (copy / "rtl/common/gc_scale.vhd").unlink()
    else:
        script = copy / "scripts" / f"{vendor}_import.tcl"
        script.write_text(script.read_text().replace("dict with project {", "dict with project {\n    analyze_files"))
    with pytest.raises(AssertionError, match="gc_scale.vhd" if fault == "source" else "analyze_files"):
        run_import(vendor, tmp_path, root=copy)


def port_bits(entity: str) -> dict[str, str]:
    """Direction of each bit of an entity's ports; vectors as two bits."""
    text = source_of(RTL, entity).read_text()
    ports = re.search(r"^  port \((.*?)^  \);", text, re.M | re.S).group(1)
    bits = {}
    for name, direction, kind in re.findall(r"^ +(\w+) *: (in|out) +(\w+(?: *\()?)", ports, re.M):
        bits |= dict.fromkeys([f"{name}[0]", f"{name}[1]"] if kind.endswith("(") else [name], direction)
    return bits


@pytest.mark.parametrize("extension", ["xdc", "sdc"])
@pytest.mark.parametrize("top", TOPS)
def test_constraints_name_the_ports_and_cover_the_crossings(top, extension):
    bits = port_bits(top)
    lines = [words for (line,) in tclsh("constraints.tcl", str(ROOT / "constraints" / f"{top}.{extension}"), *bits)
             for words in [line.replace("{", "").replace("}", "").split()]]  # fmt: skip
    clocks = {words[2] for words in lines if words[0] == "create_clock"}
    assert clocks == {name for name in bits if name.endswith("clk")}
    pins = {k for k, way in bits.items() if way == "in" and k.startswith(("pin_", "estop_n", "brake_fed"))}
    assert {name for words in lines if words[0] == "set_false_path" for name in words[1:]} == pins
    crossings = {(a, b) for a in clocks for b in clocks if a != b}
    assert {tuple(words[1:3]) for words in lines if words[0] == "set_max_delay"} == crossings
    if extension == "sdc":
        assert {tuple(words[1:3]) for words in lines if words[0] == "set_min_delay"} == crossings


def test_core_file_lists_the_sources_in_order():
    """FuseSoC's file and rtl/sources.f are one list; the version is the package's."""
    described = (ROOT / "gravcomp.core").read_text()
    listed = re.search(r"^  rtl:\n    files:\n((?:      - .*\n)*)", described, re.M).group(1)
    assert [str(ROOT / name) for name in re.findall("- (.*)", listed)] == SOURCES
    assert re.search(r"^name: .*:(.*)$", described, re.M).group(1) == __version__


def fusesoc(folder: Path, *arguments: str) -> str:
    """What `fusesoc run` prints; its build goes to the folder."""
    program = Path(sys.executable).parent / "fusesoc"
    command = [program, "--cores-root", ROOT, "run", "--build-root", folder / "build", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Replacing gravcomp" not in done.stderr, "the installed copy is taken, not the one here"
    return done.stdout


@pytest.mark.parametrize("count", [0, 12345])
def test_fusesoc_simulates_an_inference(count, tmp_path):
    printed = fusesoc(tmp_path, "--target=sim", "gravcomp:gravcomp:gravcomp", "--count_g", str(count))
    force_mn = [int(value) for value in re.findall(r"force \d+: (-?\d+) mN", printed)]
    fixed = fixed_network()
    np.testing.assert_array_equal(force_mn, core(np.full(fixed.n_axes, count), fixed).force_mn)


CORE = yaml.safe_load((ROOT / "gravcomp.core").read_text().removeprefix("CAPI=2:"))
TARGETS = [
    ("default", "gc_force_path"),
    ("system", "gc_system"),
    ("serial", "gc_serial_system"),
    ("core", "gc_core"),
]
KINDS = {"positive": "int", "natural": "int", "integer": "int", "boolean": "bool"}


@pytest.mark.parametrize("target", CORE["targets"])
def test_fusesoc_exposes_every_generic(target):
    """With its type and no second default: what is not given is what the VHDL says."""
    top = CORE["targets"][target]["toplevel"]
    source = source_of(RTL, top) if target != "sim" else ROOT / "tb/hdl" / f"{top}.vhd"
    entity = source.read_text().partition("architecture")[0]
    generics = dict(re.findall(r"^ +(\w+_g) +: (\w+)(?: range [\w ]+?)? +:=", entity, re.M))
    assert CORE["targets"][target]["parameters"] == list(generics)
    for name, kind in generics.items():
        described = {
            "datatype": KINDS[kind],
            "paramtype": "generic",
            "description": CORE["parameters"][name]["description"],
        }
        assert CORE["parameters"][name] == described


@pytest.mark.parametrize("tool", ["vivado", "quartus"])
@pytest.mark.parametrize(("target", "top"), TARGETS)
def test_fusesoc_hands_on_every_generic(tool, target, top, tmp_path):
    values = {"int": 1, "bool": "true"}
    wanted = {name: values[CORE["parameters"][name]["datatype"]] for name in CORE["targets"][target]["parameters"]}
    options = [f"--{name}={value}" for name, value in wanted.items()]
    fusesoc(tmp_path, "--setup", f"--target={target}", f"--tool={tool}", "gravcomp:gravcomp:gravcomp", *options)
    script = "".join(path.read_text() for path in tmp_path.rglob("*.tcl"))
    for name, value in wanted.items():
        assert re.search(rf"\b{name}[= ]{value}\b", script), name


@pytest.mark.parametrize("tool", ["vivado", "quartus"])
@pytest.mark.parametrize(("target", "top"), TARGETS[:3])
def test_fusesoc_sets_up_a_project(tool, target, top, tmp_path):
    """The project's script; the vendor's tool is not run."""
    fusesoc(tmp_path, "--setup", f"--target={target}", f"--tool={tool}", "gravcomp:gravcomp:gravcomp", "--lanes_g", "5")
    script = "".join(path.read_text() for path in tmp_path.rglob("*.tcl"))
    names = re.findall(r"(?:read_vhdl|VHDL_FILE).*/rtl/([\w/]+\.vhd)", script)
    assert names == (RTL / "sources.f").read_text().split()
    extension = {"vivado": "xdc", "quartus": "sdc"}[tool]
    assert f"constraints/{top}.{extension}" in script
    assert re.search(rf"(?:property top|TOP_LEVEL_ENTITY) {top}\b", script)
    assert re.search(r"lanes_g[= ]5\b", script)


@pytest.mark.parametrize(
    ("line", "is_refused"),
    [
        ("a <= abs b;", True),
        ("a <= minimum(b, c);", True),
        ("a <= '1' when b ?= c else '0';", True),
        ("a <= or b;", True),
        ("if and b then", True),
        ("case? a is", True),
        ("a <= <<signal .top.b : bit>>;", True),
        ("package p is new work.q;", True),
        ("constant late_c : natural;", True),
        ("wait until a;", True),
        ("a <= \\b.c\\;", True),
        ("p_a : process (clk) is begin a <= b when c else d; end process p_a;", True),
        ("p_a : process (all) is begin b <= c;\n a(1) <=\n '1' WHEN c = 1\n else '0';\n end process p_a;", True),
        ("p_a : process (all) is begin with a select b <= '1' when c, '0' when others; end process p_a;", True),
        ("procedure a (signal b : out bit; c : bit) is begin b <= '1' when c else '0'; end procedure a;", True),
        ("function a return bit is begin b := '1' when c else '0'; return b; end function a;", True),
        ("p_a : process (all) is begin b <= c; end process p_a; a <= b when c else d;", False),
        (
            "p_a : process (all) is begin if a <= b then case c is when d => e := f; when others => g := h; end case;"
            " else i <= j; end if; end process p_a;",
            False,
        ),
        ("a <= b or c; -- abs", False),
        ("constant c : natural := 3;", False),
    ],
)
def test_lint_refuses_constructs_that_a_tool_lacks(line, is_refused, tmp_path):
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    (tmp_path / "rtl").mkdir()
    (tmp_path / "rtl/sources.f").write_text("gc_one.vhd\n")
    (tmp_path / "rtl/gc_one.vhd").write_text(f"  {line}\n")
    done = subprocess.run([tmp_path / "scripts/lint_constructs.sh"], capture_output=True, text=True)
    assert (done.returncode, "gc_one.vhd:" in done.stderr) == ((1, True) if is_refused else (0, False)), done.stderr


def test_lint_names_the_line(tmp_path):
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    (tmp_path / "rtl").mkdir()
    (tmp_path / "rtl/sources.f").write_text("gc_one.vhd\n")
    (tmp_path / "rtl/gc_one.vhd").write_text("-- a\nprocess\nbegin\n\n  a <= b;\n  a <= b when c\n    else d;\n")
    done = subprocess.run([tmp_path / "scripts/lint_constructs.sh"], capture_output=True, text=True)
    assert done.stderr.startswith("rtl/gc_one.vhd:6:  a <= b when c")


def test_sources_hold_no_construct_that_a_tool_lacks():
    """Every file of sources.f, the generated ones as well."""
    done = subprocess.run([ROOT / "scripts/lint_constructs.sh"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


VUNIT = """
from vunit import VUnit
arguments = ["--compile", "--output-path", "out", "--no-color"]
project = VUnit.from_argv(arguments, compile_builtins=False, vhdl_standard="2008")
project.add_library("gravcomp").add_source_files({sources})
project.main()
"""


def test_vunit_reads_and_compiles_the_sources(tmp_path):
    """VUnit finds the order of the files itself, so it must be able to parse each."""
    (tmp_path / "run.py").write_text(VUNIT.format(sources=sorted(SOURCES)))
    done = subprocess.run([sys.executable, "run.py"], cwd=tmp_path, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Failed to parse" not in done.stdout + done.stderr
    assert done.stdout.count("passed") >= len(SOURCES)
