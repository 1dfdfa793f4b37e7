"""The compensator's constants, tables and bit-true model: bad input, bounds against the float model, rest, wraps."""

from dataclasses import replace

import numpy as np
import pytest

from compensated import N_AXES, SLOW, compensated_weights, constants, draw_periods
from gravcomp.core.compensation import load_compensation, no_compensation, save_compensation
from gravcomp.core.compensator_tables import FRICTION_BITS, quantise_compensation
from gravcomp.core.formats import FORCE_BITS
from gravcomp.errors import InputError
from gravcomp.twin.compensator import compensator, friction, period_of, position_table
from gravcomp.twin.encoder import NO_PERIOD, DecoderConfig, quad_decoder, quadrature
from machines import MACHINE

M_PER_COUNT = MACHINE.drive.unit_per_count
HEADER = "axis,name,value\n"
DEAD_BAND = "all,v_dead,1e-4\nall,v_full,2e-4\n"


@pytest.fixture(scope="module")
def rich(tmp_path_factory):
    return constants(compensated_weights(tmp_path_factory.mktemp("rich")))


def read(folder, text: str):
    (folder / "compensation.csv").write_text(text)
    return quantise_compensation(load_compensation(folder, N_AXES), MACHINE.drive, folder)


def test_compensation_survives_writing_and_reading(rich, tmp_path):
    save_compensation(rich[0], tmp_path, "made by a test\nin two lines")
    again = load_compensation(tmp_path, N_AXES)
    for name, value in vars(rich[0]).items():
        np.testing.assert_array_equal(getattr(again, name), value, err_msg=name)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("", "row 0 .header.: found nothing"),
        ("axis,value\n", "row 0 .header.: found axis,value"),
        (HEADER + "1,mu\n", "row 1: 2 columns"),
        (HEADER + "# note\n4,mu,0.1\n", "row 1, column axis: '4'"),
        (HEADER + "1,friction,0.1\n", "row 1, column name: 'friction'"),
        (HEADER + "1,a33,0.1\n", "row 1, column name: 'a33'"),
        (HEADER + "1,fc_pos,1\nall,fc_pos,2\n", "row 2, column name: fc_pos of axis 1 was given in row 1"),
        (HEADER + "1,fc_pos,nan\n", "row 1, column value: 'nan'"),
        (HEADER + "1,mu,1\n", "row 1, column value: mu = 1 must be in"),
        (HEADER + "1,pitch,-1\n", "row 1, column value: pitch = -1 must not"),
        (HEADER + "all,clock_hz,1e8\n", "row 1, column name: clock_hz stands in robot.toml"),
        (HEADER + "2,fc_neg,1\n", "axis 2: v_dead is missing"),
        (HEADER + "2,fc_neg,1\nall,v_dead,1e-4\n", "axis 2: v_full must be above"),
        (HEADER + DEAD_BAND + "1,stribeck,1\n", "axis 1: vs is missing"),
        (HEADER + "3,a1,1\n", "axis 3: pitch is missing"),
        (HEADER + "3,a1,1\n3,pitch,511e-6\n", "axis 3: pitch is below 512 counts"),
        (HEADER + "3,a1,132\n3,pitch,0.01\n", "axis 3: the harmonics exceed 131.071 N"),
        (HEADER + DEAD_BAND + "1,fc_neg,-131.1\n", "axis 1: Coulomb and Stribeck friction exceed"),
        (HEADER + "all,v_dead,1e-9\nall,v_full,1\n1,mu,0.1\n", "v_dead is too slow"),
    ],
)
def test_bad_compensation_is_named(tmp_path, text, complaint):
    with pytest.raises(InputError, match=complaint) as raised:
        read(tmp_path, text)
    assert str(tmp_path / "compensation.csv") in str(raised.value)
    assert "\n" not in str(raised.value)


def test_names_with_the_units_of_a_linear_axis_are_read_too(tmp_path):
    rows = (("1,fc_pos", "_n", 1), ("1,stribeck", "_n", 2), ("1,vs", "_mps", 1e-3), ("1,b_neg", "_ns_per_m", 3),
            ("1,v_dead", "_mps", 1e-4), ("1,v_full", "_mps", 2e-4), ("1,v_max", "_mps", 0.1), ("2,pitch", "_m", 0.01),
            ("2,a2", "_n", 0.5), ("2,p2_rad", "", 1))  # fmt: skip
    now, then = (
        read(tmp_path, HEADER + "".join(f"{name}{unit * is_old},{value}\n" for name, unit, value in rows))
        for is_old in (False, True)
    )
    for name, value in vars(now).items():
        np.testing.assert_array_equal(getattr(then, name), value)
        assert value.any() == (name != "mu")


def test_without_a_file_the_compensator_is_transparent(tmp_path):
    fixed = quantise_compensation(load_compensation(tmp_path, N_AXES), MACHINE.drive, tmp_path)
    rng = np.random.default_rng(1)
    force = rng.integers(-(2 ** (FORCE_BITS - 1)), 2 ** (FORCE_BITS - 1), (1000, N_AXES))
    count = rng.integers(-(2**31), 2**31, force.shape)
    out, saturated = compensator(force, count, draw_periods(force.shape, rng), fixed)
    np.testing.assert_array_equal(out, force)
    assert not saturated.any()


def test_friction_is_within_its_derived_bound_of_the_float_model(rich):
    """Chord of 1/P and of exp(-(v/vs)^2) over an eighth of an octave's start; half an LSB of nodes and of the sum.

    With x = P over the segment's start, h = 1/8: error <= h^2/8 max|g''|; g'' of 1/x is at most 2, that of
    exp(-(u/x)^2) at most |4 u^4 - 6 u^2| exp(-u^2) <= 1.22. mu |f| adds half an LSB of mu and its place, times |f|.
    """
    c, drive = rich[0], replace(SLOW.drive, clock_hz=1e8)
    fixed = quantise_compensation(c, drive)
    rng = np.random.default_rng(2)
    speed = 10.0 ** rng.uniform(np.log10(1.13 * 4e-4), np.log10(0.015), (20_000, 1)) * np.ones(N_AXES)
    period = period_of(speed * rng.choice([-1, 1], speed.shape), drive)
    v = 4 * drive.clock_hz * M_PER_COUNT / period
    force_mn = rng.integers(-130_000, 130_000, v.shape)
    exact_mn = 1e3 * c.friction(v) + np.sign(v) * c.mu * np.abs(force_mn)
    bound_mn = 1.5 + 1e3 * (2 / 512 * c.b_pos * np.abs(v) * 9 / 8 + 1.22 / 512 * np.abs(c.stribeck))
    bound_mn = bound_mn + 2.0**-17 * np.abs(force_mn)
    part = np.abs(friction(force_mn, period, fixed) - exact_mn) / bound_mn
    assert part.max() <= 1
    assert part[:, 0].max() > 0.5, "the bound is far too wide"


def test_friction_differs_by_direction(rich):
    c, fixed = rich
    rest, period = np.zeros((1, N_AXES), int), np.full((1, N_AXES), 16)
    forward, backward = friction(rest, period, fixed), friction(rest, -period, fixed)
    v = np.full(N_AXES, SLOW.drive.clock_hz * 4 * M_PER_COUNT / 16)
    np.testing.assert_allclose(forward[0], 1e3 * c.friction(v), atol=1.0)
    np.testing.assert_allclose(backward[0], 1e3 * c.friction(-v), atol=1.0)
    assert forward[0, 0] > 0 > backward[0, 0]
    assert forward[0, 0] + backward[0, 0] == pytest.approx(
        1e3 * (c.fc_pos - c.fc_neg + (c.b_pos - c.b_neg) * v)[0], abs=2.0
    )


def test_friction_rises_from_zero_and_never_changes_sign(rich):
    """Every period near and inside the dead band, both directions; exactly zero up to the last node above v_dead."""
    c, fixed = rich
    period = np.unique(np.rint(2.0 ** np.linspace(4, 31, 200_000)).astype(np.int64).clip(1, NO_PERIOD))
    up = friction(np.zeros((len(period), N_AXES), int), np.repeat(period[:, None], N_AXES, 1), fixed)[:, 0]
    down = friction(np.zeros((len(period), N_AXES), int), -np.repeat(period[:, None], N_AXES, 1), fixed)[:, 0]
    assert (up >= 0).all()
    assert (down <= 0).all()
    v = 4 * SLOW.drive.clock_hz * M_PER_COUNT[0] / period
    still = v <= c.v_dead[0] * 8 / 9
    assert still.any()
    assert not up[still].any()
    assert not down[still].any()
    in_ramp = (v > c.v_dead[0]) & (v < c.v_full[0])
    assert (np.diff(up[in_ramp]) <= 0).all(), "it must fall as the axis slows down"
    assert (up[in_ramp] <= 1e3 * (c.fc_pos + c.stribeck + c.b_pos * c.v_full)[0] + 1).all()


@pytest.mark.parametrize("pace", [8, 40, 300])
def test_friction_stays_zero_while_an_axis_dithers_about_an_edge(rich, pace):
    """Positions jump by one count to and fro, at random intervals, before and after a real motion in one direction."""
    _, fixed = rich
    rng = np.random.default_rng(pace)
    hops = np.cumsum(rng.integers(8, pace + 8, 400))
    clocks = np.arange(hops[-1] + 50)
    position = 6 + np.searchsorted(hops, clocks, side="right") % 2
    a, b = quadrature(position)
    zero = np.zeros_like(clocks)
    names = ("rst", "z", "cfg_home_enable", "cfg_index_position", "cfg_clear")
    config = DecoderConfig(filter_samples=2, speed_timeout=200)
    out = quad_decoder({"a": a, "b": b, **dict.fromkeys(names, zero)}, config)
    assert np.abs(np.diff(out["count"])).sum() > 300, "the decoder must see the dither"
    period = np.repeat(out["speed_period"][:, None], N_AXES, 1)
    force = rng.integers(-100_000, 100_000, period.shape)
    assert not friction(force, period, fixed).any()


def test_position_table_is_within_its_derived_bound_and_wraps(rich):
    """Chord of a sine over 1/256 turn, half an LSB of nodes and of the sum, drift of the phase."""
    c, fixed = rich
    rng = np.random.default_rng(4)
    count = rng.integers(-160_000, 160_000, (20_000, N_AXES))
    pitch_counts = np.where(c.pitch > 0, c.pitch / M_PER_COUNT, 1.0)
    h = np.arange(1, c.amplitude.shape[1] + 1)
    chord_mn = 1e3 * np.sum(np.abs(c.amplitude) * (2 * np.pi * h / 256) ** 2 / 8, axis=1)
    slope_mn = 1e3 * np.sum(np.abs(c.amplitude) * 2 * np.pi * h, axis=1)
    drift_turns = np.abs(count) * 2.0**-33 + 2.0**-25
    error_mn = np.abs(position_table(count, fixed) - 1e3 * c.cogging(count / pitch_counts))
    assert (error_mn <= 1.0 + chord_mn + slope_mn * drift_turns).all()
    step_mn = slope_mn / pitch_counts + 2.0
    around = np.arange(-40_000, 40_000)[:, None] + np.zeros(N_AXES, int)
    assert (np.abs(np.diff(position_table(around, fixed), axis=0)) <= step_mn).all()
    over_the_end = (np.arange(2**31 - 300, 2**31 + 300)[:, None] + 2**31) % 2**32 - 2**31 + np.zeros(N_AXES, int)
    assert (np.abs(np.diff(position_table(over_the_end, fixed), axis=0)) <= step_mn).all()


def test_nothing_overflows_before_the_saturation(rich, tmp_path):
    """Constants at their limits and inputs at their corners stay in the widths that the entities have."""
    text = HEADER + DEAD_BAND + "all,fc_pos,131\nall,fc_neg,131\nall,b_pos,1e9\nall,mu,-0.999999\n"
    limits = read(tmp_path, text + "all,pitch,0.01\nall,a1,131\n")
    corners = np.array([-(2 ** (FORCE_BITS - 1)), -1, 0, 1, 2 ** (FORCE_BITS - 1) - 1])
    force, period, count = np.meshgrid(
        corners, [-(2**31), -(2**31) + 1, -5000, -1, 0, 1, 5000, NO_PERIOD], [-(2**31), -2500, 0, 2500, 2**31 - 1]
    )
    force, period, count = (np.repeat(x.reshape(-1, 1), N_AXES, 1) for x in (force, period, count))
    for fixed in (rich[1], limits):
        added = friction(force, period, fixed)
        assert np.abs(added).max() < 2 ** (FRICTION_BITS - 1)
        assert np.abs(position_table(count, fixed)).max() < 2**17
        out, saturated = compensator(force, count, period, fixed)
        exact = force + added + position_table(count, fixed)
        np.testing.assert_array_equal(saturated, out != exact)
        np.testing.assert_array_equal(out, exact.clip(corners[0], corners[-1]))
    assert saturated.any()


def test_period_of_a_speed_is_that_of_the_speed_meter():
    period = period_of(np.array([[0.0025, -0.0025, 0.0]]), SLOW.drive)
    np.testing.assert_array_equal(period, [[16, -16, NO_PERIOD]])
    assert no_compensation(N_AXES).n_axes == N_AXES
