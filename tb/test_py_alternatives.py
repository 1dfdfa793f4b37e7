"""What a report lists as alternatives: what is as good and says another thing, and nothing that says the same."""

import numpy as np
import pytest

from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report.report import report
from gravcomp.logs.csv_reader import read_measurement

N = 400
T = 0.05 * np.arange(N)


def listed(tmp_path, q, v, model, force, noise=0.05) -> list[set[str]]:
    f = model + force + noise * np.random.default_rng(1).standard_normal(N)
    lines = [",".join(f"{x:.9g}" for x in row) for row in np.column_stack([T, q, v, f, model])]
    (tmp_path / "log.csv").write_text("\n".join(["t_s,q1_rad,v1_radps,f1_nm,fm1_nm", *lines]) + "\n")
    found = report(diagnose(read_measurement(tmp_path / "log.csv"), Model()))
    return [{*names} for names in found["alternatives"]]


def swing(reach: float):
    """Position and velocity of a motion of two sines, so far to either side."""
    return (reach * (0.7 * np.sin(0.9 * T) + 0.3 * np.sin(0.53 * T)),
            reach * (0.63 * np.cos(0.9 * T) + 0.159 * np.cos(0.53 * T)))  # fmt: skip


def test_offset_is_no_spring_where_a_spring_would_show(tmp_path):
    q, v = swing(1.4)
    assert listed(tmp_path, q, v, 8.0 * np.cos(q), 0.5) == []


def test_offset_may_be_a_spring_where_the_log_leaves_room_for_one(tmp_path):
    q, v = swing(1.4)
    few = np.arange(N) < 40  # the others stand still
    q, v = np.where(few, q, q[40]), np.where(few, v, 0.0)
    names = listed(tmp_path, q, v, 8.0 * np.cos(q), 0.1, noise=0.1)
    assert any("cable_spring" in own for own in names)


def test_two_effects_together_are_no_alternative_where_one_of_them_is(tmp_path):
    """On a constant load a thrust constant is an offset; with friction beside it, it still is no more than that."""
    q, v = swing(1.4)
    (names,) = listed(tmp_path, q, v, np.full(N, 8.0), 0.5)
    assert {"thrust_constant", "current_offset"} <= names
    assert not names & {"coulomb_friction", "viscous_friction"}


@pytest.mark.parametrize("speed", [0.02, None])
def test_friction_at_one_speed_may_be_viscous_and_at_several_not(tmp_path, speed):
    rng = np.random.default_rng(2)
    q = rng.uniform(-1.4, 1.4, N)
    v = rng.choice([-1.0, 1.0], N) * (speed or rng.choice([0.002, 0.02, 0.2], N))
    names = listed(tmp_path, q, v, 8.0 * np.cos(q), 0.3 * np.sign(v))
    assert any("viscous_friction" in own for own in names) == (speed is not None)
