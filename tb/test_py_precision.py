"""What the formats cost: told by rom, image and formats, refused above a bound, and what costs it is named."""

from dataclasses import replace

import numpy as np
import pytest

from codes import ROOT
from gravcomp.cli import main
from gravcomp.core.formats import quantise
from gravcomp.network.weights import HIDDEN_CSV, OUTPUT_CSV, SCALING_CSV, load_network
from gravcomp.twin.precision import precision
from machines import MACHINE, like_shipped, machine_folder

SHIPPED = ROOT / "weights" / "spheiro"
STEP_M = MACHINE.drive.unit_per_count


def with_value(network, table: str, place: tuple[int, ...], value: float):
    values = getattr(network, table).copy()
    values[place] = value
    return replace(network, **{table: values})


HUGE = [  # table, place, value; and what must be named
    ("hidden_weights", (4, 1), 1000.0, f"{HIDDEN_CSV}: row 5, column w_q2: 1000 "),
    ("hidden_weights", (0, 0), -60000.0, f"{HIDDEN_CSV}: row 1, column w_q1: -60000 "),
    ("output_weights", (2, 19), 1000.0, f"{OUTPUT_CSV}: row 3, column v_20: 1000 "),
    ("q_offset", (1,), 100.0, f"{SCALING_CSV}: row 2, column q_offset: 100 "),
]
IDS = ["hidden", "hidden_negative", "output", "offset"]


@pytest.fixture(scope="module")
def network():
    return load_network(SHIPPED)


@pytest.mark.parametrize("huge", HUGE, ids=IDS)
@pytest.mark.parametrize("command", ["rom", "image", "formats"])
def test_a_huge_value_is_refused_in_one_line_that_names_it(network, command, huge, tmp_path, capsys):
    folder, out = tmp_path / "weights", tmp_path / "out"
    machine_folder(folder, with_value(network, *huge[:3]))
    arguments = {
        "rom": ["--weights", str(folder), "--out", str(out)],
        "image": ["--weights", str(folder), "--rom", str(folder), "--out", str(out)],
        "formats": ["--weights", str(folder)],
    }
    assert main([command, *arguments[command]]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert huge[3] in complaint
    assert "mN RMS off, limit 17.9 mN" in complaint
    assert not out.exists()


def test_an_image_for_a_core_of_coarse_formats_names_the_weight_of_that_core(network, tmp_path, capsys):
    core = tmp_path / "core"
    machine_folder(core, with_value(network, *HUGE[0][:3]))
    assert main(["image", "--weights", str(SHIPPED), "--rom", str(core), "--out", str(tmp_path / "out")]) == 2
    complaint = capsys.readouterr().err
    assert f"{core}/{HUGE[0][3]}" in complaint
    assert f"build one from {SHIPPED}" in complaint


@pytest.mark.parametrize("command", ["rom", "image"])
def test_the_cost_is_told(command, tmp_path, capsys):
    core = ["--rom", str(SHIPPED)] if command == "image" else []
    assert main([command, "--weights", str(SHIPPED), *core, "--out", str(tmp_path / "out")]) == 0
    assert "the formats cost 1.68 mN RMS, 8.07 mN at most" in capsys.readouterr().out


@pytest.mark.parametrize("huge", HUGE, ids=IDS)
def test_the_stage_named_is_the_one_that_costs(network, huge):
    """Its cost alone is that of the whole core, and no other stage has half of it."""
    spoilt = with_value(network, *huge[:3])
    found = precision(spoilt, quantise(spoilt, MACHINE.drive), STEP_M)
    assert found.rms_mn > 10 * found.limit_mn
    assert found.stages[0].rms_mn == pytest.approx(found.rms_mn, rel=0.1)
    assert found.stages[1].rms_mn < found.stages[0].rms_mn / 2


def test_networks_that_use_their_bits_stay_far_below_the_limit():
    """Drawn weights of every size of network, offsets and scales that differ from axis to axis."""
    for seed in range(20):
        rng = np.random.default_rng(seed)
        n, h = rng.integers(1, 5), rng.integers(2, 24)
        drawn = replace(
            load_network(SHIPPED),
            hidden_weights=rng.uniform(-3, 3, (h, n)),
            hidden_bias=rng.uniform(-1, 1, h),
            output_weights=rng.uniform(-1, 1, (n, h)),
            output_bias=rng.uniform(-0.2, 0.2, n),
            q_offset=rng.uniform(-0.05, 0.05, n),
            q_scale=rng.uniform(5, 8, n),
            f_offset=rng.uniform(-50, 50, n),
            f_scale=rng.uniform(40, 70, n),
        )
        found = precision(drawn, quantise(drawn, like_shipped(int(n))), 1e-6)
        assert found.rms_mn < found.limit_mn / 4


def test_saturated_forces_are_no_cost_of_the_formats(network):
    """They are flagged at run time; what is left of the sample still counts."""
    beyond = replace(network, output_bias=network.output_bias + np.array([0.9, 0, 0]))
    found = precision(beyond, quantise(beyond, MACHINE.drive), STEP_M)
    assert 1.0 < found.rms_mn < found.limit_mn
