"""Formats and the bit-true model: no overflow for any count, proven by intervals; distance from the float network."""

import numpy as np
import pytest

from codes import ROOT
from gravcomp.core.formats import CURRENT_BITS, bits_for, partial_sum_interval, quantise
from gravcomp.errors import InputError
from gravcomp.network.activation import gamma
from gravcomp.network.weights import Network, load_network
from gravcomp.robot.machine import Drive
from gravcomp.robot.spheiro.workspace import pose
from gravcomp.twin import network as bittrue
from gravcomp.twin.bounds import fixed_point_error_mn, intervals
from gravcomp_lab.simulated.poses import counts_at
from machines import MACHINE, P

SEED = 41


@pytest.fixture(scope="module")
def network() -> Network:
    return load_network(ROOT / "weights" / "spheiro")


@pytest.fixture(scope="module")
def fixed(network):
    return quantise(network, MACHINE.drive)


def test_core_stays_within_3_mn_rms_and_15_mn_of_the_float_network(network, fixed):
    error_mn = fixed_point_error_mn(network, fixed, MACHINE, 20000, SEED)
    assert np.sqrt((error_mn**2).mean()) <= 3.0
    assert np.abs(error_mn).max() <= 15.0


def test_whole_workspace_lies_inside_the_trained_range(fixed):
    """The corners of tilt and torsion, not just a sample: no pose of the workspace is clamped."""
    torsions = np.deg2rad([-P.torsion_max_deg, 0, P.torsion_max_deg])
    azimuth, torsion = np.meshgrid(np.linspace(0, 2 * np.pi, 721), torsions)
    assert not bittrue.core(counts_at(pose(azimuth, np.deg2rad(P.tilt_max_deg), torsion), MACHINE), fixed).clamped.any()


def test_no_signal_overflows_for_any_count(fixed):
    for name, interval in intervals(fixed).items():
        assert interval.needed_bits <= interval.bits, name


def test_intervals_hold_what_the_model_computes(fixed):
    """The intervals are not too narrow: the model, run far outside and inside, stays within them."""
    rng = np.random.default_rng(SEED)
    counts = np.concatenate([rng.integers(-(2**31), 2**31, (2000, 3)), rng.integers(-170000, 170000, (20000, 3))])
    x, _ = bittrue.input_scaler(counts, fixed)
    a = bittrue.hidden_lane(x, fixed)
    h = bittrue.activation(a)
    seen = {
        "x": x,
        "hidden sum": x @ fixed.hidden_weights.T + fixed.hidden_bias,
        "h": bittrue.activation(np.arange(-(2**17), 2**17)),
        "output sum": bittrue.output_layer(h, fixed),
        "force, mN": bittrue.core(counts, fixed).force_mn,
    }
    bounds = intervals(fixed)
    for name, values in seen.items():
        assert bounds[name].low <= values.min(), name
        assert values.max() <= bounds[name].high, name
    assert (seen["x"].min(), seen["x"].max()) == (bounds["x"].low, bounds["x"].high), "the clamp reaches the ends of x"


def test_partial_sums_of_a_known_case_have_the_known_interval():
    weights, bias = np.array([[3, -2]]), np.array([-1])
    # terms in [-3, 3] and [-2, 2], bias -1: any subset lies in [-6, 5]
    assert partial_sum_interval(weights, bias, -1, 1) == (-6, 5)


@pytest.mark.parametrize(
    ("low", "high", "bits"), [(0, 0, 1), (-1, 0, 1), (0, 1, 2), (-2, 1, 2), (-3, 0, 3), (-8, 8, 5)]
)
def test_bits_for_is_the_smallest_signed_width(low, high, bits):
    assert bits_for(low, high) == bits


def test_activation_stays_within_its_stated_bounds_of_gamma():
    a = np.arange(-(2**17), 2**17)
    error_lsb = bittrue.activation(a) - gamma(a / 2.0**16) * 2.0**17
    assert error_lsb[a >= 0].min() > -2
    assert error_lsb[a >= 0].max() <= 0
    assert error_lsb[a < 0].min() > -1
    assert error_lsb[a < 0].max() <= 1


def test_outside_the_trained_range_the_output_holds_and_the_flag_says_so(fixed):
    edge = np.stack([fixed.count_low, fixed.count_high])
    beyond = np.stack([fixed.count_low - 1, fixed.count_high + 1])
    far = np.sign(edge) * (2**31 - 1)
    at_edge = bittrue.core(edge, fixed)
    assert not at_edge.clamped.any()
    for counts in (beyond, far):
        answer = bittrue.core(counts, fixed)
        assert answer.clamped.all()
        np.testing.assert_array_equal(answer.force_mn, at_edge.force_mn)


def test_output_beyond_its_format_saturates_and_the_flag_says_so(fixed):
    edge = 2**17 << fixed.output_drop
    force_mn, is_saturated = bittrue.output_scaler(np.array([[edge - 1] * 3, [edge] * 3, [2 * edge] * 3]), fixed)
    assert is_saturated.tolist() == [[False] * 3, [True] * 3, [True] * 3]
    np.testing.assert_array_equal(force_mn[1], force_mn[0])
    np.testing.assert_array_equal(force_mn[2], force_mn[0])


def test_offsets_and_unequal_scales_are_folded_without_loss():
    """A network of another size with offsets on every axis keeps to its float twin within the same bounds."""
    rng = np.random.default_rng(SEED)
    network = Network(
        hidden_weights=rng.uniform(-1.5, 1.5, (7, 3)),
        hidden_bias=rng.uniform(-1, 1, 7),
        output_weights=rng.uniform(-0.5, 0.5, (3, 7)),
        output_bias=rng.uniform(-0.1, 0.1, 3),
        q_offset=np.array([0.03, -0.05, 0.01]),
        q_scale=np.array([5.0, 8.0, 6.5]),
        f_offset=np.array([20.0, -40.0, 60.0]),
        f_scale=np.array([40.0, 70.0, 55.0]),
        position_units=("m",) * 3,
    )
    fixed = quantise(network, MACHINE.drive)
    counts = rng.integers(fixed.count_low, fixed.count_high, (5000, 3))
    error_mn = bittrue.core(counts, fixed).force_mn - 1000.0 * network.forces(counts * MACHINE.drive.unit_per_count)
    assert np.sqrt((error_mn**2).mean()) <= 3.0
    assert np.abs(error_mn).max() <= 15.0
    assert np.abs(error_mn.mean(axis=0)).max() <= 1.0, "a bias: something was not folded in"


def unlike(effort_per_ampere: list[float]) -> tuple[Network, Drive]:
    """A shoulder of 150 Nm and 8 192 000 counts per turn beside a wrist of 2 Nm and 4096, and their drives."""
    rng = np.random.default_rng(SEED)
    network = Network(
        hidden_weights=rng.uniform(-1.5, 1.5, (8, 2)),
        hidden_bias=rng.uniform(-1, 1, 8),
        output_weights=rng.uniform(-0.5, 0.5, (2, 8)),
        output_bias=rng.uniform(-0.1, 0.1, 2),
        q_offset=np.array([0.1, -0.2]),
        q_scale=np.array([0.4, 0.9]),
        f_offset=np.array([10.0, -0.3]),
        f_scale=np.array([150.0, 2.0]),
        position_units=("rad", "rad"),
    )
    return network, Drive(np.array([8_192_000, 4096]) / (2 * np.pi), np.array(effort_per_ampere), 40e6)


def test_unlike_axes_each_keep_their_precision():
    """What one axis needs costs the other nothing: each is as close to its float twin as its own counts allow."""
    network, drive = unlike([45.0, 0.05])
    fixed = quantise(network, drive)
    assert (np.diff(fixed.count_shift) < 0).all()
    counts = np.random.default_rng(SEED).integers(fixed.count_low, fixed.count_high, (5000, 2))
    effort_mnm = bittrue.core(counts, fixed).force_mn
    error_mnm = effort_mnm - 1000.0 * network.forces(counts * drive.unit_per_count)
    # 17 bits of y, some of them for sums and offsets, and the last mNm
    assert (np.sqrt((error_mnm**2).mean(axis=0)) <= 1e3 * network.f_scale * 2.0**-14 + 0.5).all()
    current_ua = bittrue.current_scaler(effort_mnm, fixed)
    exact_ua = effort_mnm * 1000.0 / drive.effort_per_ampere
    assert not bittrue.current_saturates(effort_mnm, fixed).any()
    np.testing.assert_allclose(current_ua, exact_ua, rtol=2.0**-17, atol=0.5)
    for name, interval in intervals(fixed).items():
        assert interval.needed_bits <= interval.bits, name


def test_current_that_does_not_fit_saturates_and_says_so():
    """Of an axis of 0.05 Nm/A the largest effort, 8388 Nm, asks for 168 kA; of one of 45 N/A nothing is too much."""
    fixed = quantise(*unlike([45.0, 0.05]))
    most = 2 ** (CURRENT_BITS - 1)
    fits = 107_374  # mNm: 2147.48 A
    effort = np.array([[2**23 - 1, fits], [2**23 - 1, 2**23 - 1], [-(2**23), -(2**23)]])
    assert bittrue.current_saturates(effort, fixed).tolist() == [[False, False], [False, True], [False, True]]
    assert bittrue.current_scaler(effort, fixed)[:, 1].tolist() == [
        int(np.floor(fits * fixed.current_scale[1] / 2.0 ** fixed.current_scale_fraction[1] + 0.5)),
        most - 1,
        -most,
    ]


def test_effort_per_ampere_beyond_the_format_is_refused_with_its_axis():
    """Below 0.0153 Nm/A a milli-effort is more uA than an operand holds."""
    assert (quantise(*unlike([0.0153, 45.0])).current_scale_fraction >= 1).all()
    with pytest.raises(InputError, match="axis 2: effort_per_ampere is too large or small for 18 bits"):
        quantise(*unlike([45.0, 0.015]))
