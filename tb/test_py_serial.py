"""The serial form of the network: widths by error, free of overflow, clipped and flagged; images for it refused."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp.cli import main
from gravcomp.core import formats as q
from gravcomp.core import lean
from gravcomp.core.folder import folder_hash
from gravcomp.core.formats import FixedNetwork
from gravcomp.core.image import load_image
from gravcomp.core.quantised import quantised
from gravcomp.errors import InputError
from gravcomp.network.activation import gamma
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine
from gravcomp.twin.bounds import fixed_point_error_mn, intervals
from gravcomp.twin.network import activate, core, hidden_lane, input_scaler, serial_square, vertex_activation
from gravcomp_lab.forms import form_copy
from machines import MACHINE, SHIPPED

SEED, N_POSES = 1, 20000
SERIAL = MACHINE.with_form("serial")


@pytest.fixture(scope="module")
def network():
    return load_network(SHIPPED)


@pytest.fixture(scope="module")
def fixed(network) -> FixedNetwork:
    return quantised(SERIAL, network)


@pytest.mark.parametrize("seed", [41, 51, 61])  # 41: the poses of `gravcomp formats`
def test_it_is_within_18_mn_on_poses_that_no_fit_saw(fixed, network, seed):
    assert np.abs(fixed_point_error_mn(network, fixed, SERIAL, N_POSES, seed)).max() <= 18.0


def test_weights_fit_their_width_and_all_products_lose_the_same(fixed):
    assert fixed.weight_bits == 16
    for codes in (fixed.hidden_weights, fixed.output_weights):
        assert np.abs(codes).max() < 2 ** (fixed.weight_bits - 1)
    assert fixed.hidden_product_drop == fixed.output_product_drop
    assert fixed.hidden_sum_bits == fixed.output_sum_bits


@pytest.mark.parametrize("bits", [12, 16, 18])
def test_every_signal_fits_its_format_for_all_counts(network, bits):
    fixed = lean.lean_network(network, SERIAL.drive, SERIAL.robot.workspace(2000, SEED), serial_bits=bits)
    for name, interval in intervals(fixed).items():
        assert interval.needed_bits <= interval.bits, name


def test_no_partial_sum_leaves_the_one_width(fixed):
    rng = np.random.default_rng(SEED)
    counts = np.concatenate([rng.integers(-200000, 200000, (5000, 3)), 2**31 - 1 - np.zeros((1, 3), np.int64)])
    x, _ = input_scaler(counts, fixed)
    h = activate(hidden_lane(x, fixed), fixed)
    stages = [
        (fixed.hidden_bias, x[:, None, :] * fixed.hidden_weights >> fixed.hidden_product_drop),
        (fixed.output_bias, h[:, None, :] * fixed.output_weights >> fixed.output_product_drop),
    ]
    for bias, products in stages:
        terms = np.cumsum(products[..., rng.permutation(products.shape[-1])], axis=-1)
        assert max(np.abs(bias[:, None] + terms).max(), np.abs(terms).max()) < 2 ** (fixed.output_sum_bits - 1)


@pytest.mark.parametrize("bits", [12, 15, 16, 17, 18])
def test_square_is_the_vertex_form_s_but_for_the_bits_that_a_weight_has_not(fixed, bits):
    """In LSB of h: e bits of t cost up to 2^e - 1, the product's up to one LSB of the sum, at every u."""
    lost = max(17 - bits, 0)
    # 16 - e places are left below u/2 and above the LSB of the sum.
    other = replace(fixed, weight_bits=bits, output_product_drop=min(fixed.output_product_drop, 16 - lost))
    u = np.arange(2**17)
    places = 17 - lost - other.output_product_drop
    below = np.ldexp((u * u).astype(float), -17) - np.ldexp(serial_square(u, other).astype(float), -places)
    assert below.min() >= 0.0
    assert below.max() < 2**lost - 1 + 2.0**-places


def test_activation_is_gamma_at_every_code(fixed):
    a = np.arange(-(2 ** (q.OPERAND_BITS - 1)), 2 ** (q.OPERAND_BITS - 1))
    h = activate(a, fixed)
    off = h - np.ldexp(gamma(np.ldexp(a + 0.5, -q.PREACTIVATION_FRACTION)), q.HIDDEN_FRACTION)
    # The bounds of vertex_activation and one LSB of t, which is as much of h.
    assert ((off > -1) & (off <= 2 + 2.0**-7))[a >= 0].all()
    assert ((off >= -3 - 2.0**-7) & (off < 0))[a < 0].all()
    np.testing.assert_array_equal(h, -1 - h[::-1])  # odd about the middle of the codes
    assert (h != vertex_activation(a)).any(), "nothing was lost: the test sees no other form"


def test_efforts_outside_the_workspace_saturate_and_are_flagged(fixed, network):
    """Where the float network goes beyond the 131 N that 18 bits of mN hold."""
    counts = np.random.default_rng(SEED).integers(fixed.count_low, fixed.count_high + 1, (N_POSES, 3))
    found, wanted_mn = core(counts, fixed), 1000.0 * network.forces(SERIAL.drive.positions(counts))
    is_beyond = np.abs(wanted_mn) > 2**17 + 100
    assert is_beyond.any()
    assert found.saturated[is_beyond].all()
    assert not found.saturated[np.abs(wanted_mn) < 2**17 - 100].any()
    np.testing.assert_array_equal(np.unique(np.abs(found.force_mn[found.saturated] + 0.5)), [2**17 - 0.5])


def test_counts_outside_the_trained_range_are_clamped_and_flagged(fixed):
    ends = np.stack([fixed.count_low, fixed.count_high])
    beyond = np.stack([np.full(3, -(2**31)), np.full(3, 2**31 - 1)])
    inside, outside = core(ends, fixed), core(beyond, fixed)
    assert not inside.clamped.any()
    assert outside.clamped.all()
    np.testing.assert_array_equal(inside.force_mn, outside.force_mn)


def test_formats_prints_what_bits_cost(network, capsys):
    """One row per width, its error that of the network so quantised; a bit more costs less, from 12 to 17."""
    assert main(["formats", "--weights", str(SHIPPED), "--bits"]) == 0
    told = capsys.readouterr().out
    rows = [[float(cell) for cell in line.split("|")[1:-1]] for line in told.splitlines() if line.startswith("| 1")]
    assert [row[0] for row in rows] == [12, 13, 14, 15, 16, 17, 18]
    assert (np.diff([row[1] for row in rows]) < 0).all()
    fixed = quantised(SERIAL, network)
    error_mn = fixed_point_error_mn(network, fixed, SERIAL, N_POSES, 41)
    rms, largest = np.sqrt((error_mn**2).mean()), np.abs(error_mn).max()
    assert rows[4][1:] == [round(rms, 2), round(largest, 1), fixed.output_sum_bits, 16 * 120]


def test_form_is_under_the_hash(tmp_path):
    serial, other = form_copy(SHIPPED, tmp_path, "serial"), form_copy(SHIPPED, tmp_path, "lean")
    hashes = {folder_hash(folder, load_machine(folder)) for folder in (serial, other, SHIPPED)}
    assert len(hashes) == 3


@pytest.mark.parametrize(
    ("given", "rom", "told"),
    [
        ("serial", "serial", "'serial': the serial form of the core loads no image; write its ROM anew"),
        ("lean", "serial", "'lean': the serial form of the core loads no image; write its ROM anew"),
        ("serial", "lean", "'serial', but the core was built with 'lean'; give that"),
    ],
)
def test_image_of_or_for_the_serial_form_is_refused(tmp_path, given, rom, told):
    folders = [form_copy(SHIPPED, tmp_path, form) for form in (given, rom)]
    with pytest.raises(InputError, match=rf"robot.toml: \[network\] form = {told}"):
        load_image(*folders)


def test_sin_cos_is_refused_in_the_serial_form(network):
    turning = replace(network, inputs=("sin_cos", "position", "position"))
    with pytest.raises(InputError, match=r"form = 'serial' takes positions alone, not the input sin_cos; give form"):
        quantised(SERIAL, turning)
