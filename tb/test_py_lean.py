"""The lean form of the network: as accurate as the paper's, free of overflow; images for the other form refused."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp.certify.certificate import Certifier
from gravcomp.core import formats as q
from gravcomp.core.cost import CoreCost
from gravcomp.core.folder import folder_hash
from gravcomp.core.formats import FixedNetwork
from gravcomp.core.image import load_image
from gravcomp.core.lean import _in_order
from gravcomp.core.quantised import quantised
from gravcomp.errors import InputError
from gravcomp.network.activation import gamma
from gravcomp.network.weights import load_network
from gravcomp.robot.machine import load_machine, parse_machine
from gravcomp.twin.bounds import fixed_point_error_mn, intervals
from gravcomp.twin.network import core, hidden_lane, input_scaler, vertex_activation
from gravcomp.twin.precision import precision
from gravcomp_lab.forms import form_copy
from gravcomp_lab.paper.operations import lean_on_counted
from machines import MACHINE, SHIPPED, changed

SEED, N_POSES = 1, 20000
LEAN = MACHINE.with_form("lean")


@pytest.fixture(scope="module")
def network():
    return load_network(SHIPPED)


@pytest.fixture(scope="module")
def fixed(network) -> FixedNetwork:
    return quantised(LEAN, network)


@pytest.mark.parametrize("seed", [41, 51, 61])  # 41: the poses of `gravcomp formats`
def test_it_is_as_accurate_as_the_paper_s_on_poses_that_no_fit_saw(fixed, network, seed):
    error_mn = fixed_point_error_mn(network, fixed, LEAN, N_POSES, seed)
    assert np.sqrt((error_mn**2).mean()) <= 1.8
    assert np.abs(error_mn).max() <= 8.5


def test_formats_cost_little_over_the_whole_trained_range(fixed, network):
    """Outside the workspace, too, where no effort is exact but all are told to the host."""
    assert precision(network, fixed, LEAN.drive.unit_per_count).rms_mn <= 3.0


def test_weights_are_operands_and_sums_are_narrow(fixed):
    for codes in (fixed.hidden_weights, fixed.output_weights):
        assert np.abs(codes).max() < 2 ** (q.OPERAND_BITS - 1)
    assert (fixed.hidden_sum_bits, fixed.output_sum_bits) == (24, 26)  # 37 and 38 in the paper's form


def test_every_signal_fits_its_format_for_all_counts(fixed):
    for name, interval in intervals(fixed).items():
        assert interval.needed_bits <= interval.bits, name


def test_no_partial_sum_leaves_its_width(fixed):
    rng = np.random.default_rng(SEED)
    counts = np.concatenate([rng.integers(-200000, 200000, (5000, 3)), 2**31 - 1 - np.zeros((1, 3), np.int64)])
    x, _ = input_scaler(counts, fixed)
    h = vertex_activation(hidden_lane(x, fixed))
    stages = [
        (fixed.hidden_sum_bits, fixed.hidden_bias, x[:, None, :] * fixed.hidden_weights >> fixed.hidden_product_drop),
        (fixed.output_sum_bits, fixed.output_bias, h[:, None, :] * fixed.output_weights >> fixed.output_product_drop),
    ]
    for bits, bias, products in stages:
        terms = np.cumsum(products[..., rng.permutation(products.shape[-1])], axis=-1)
        assert max(np.abs(bias[:, None] + terms).max(), np.abs(terms).max()) < 2 ** (bits - 1)


def test_vertex_form_is_gamma_at_every_code():
    a = np.arange(-(2 ** (q.OPERAND_BITS - 1)), 2 ** (q.OPERAND_BITS - 1))
    h = vertex_activation(a)
    # In LSB of h, of the middle of what a code stands for: the bounds of vertex_activation, one LSB of head room.
    off = h - np.ldexp(gamma(np.ldexp(a + 0.5, -q.PREACTIVATION_FRACTION)), q.HIDDEN_FRACTION)
    assert ((off > -1) & (off <= 1))[a >= 0].all()
    assert ((off >= -2) & (off < 0))[a < 0].all()
    np.testing.assert_array_equal(h, -1 - h[::-1])  # odd about the middle of the codes


def test_efforts_outside_the_workspace_saturate_and_are_flagged(fixed, network):
    """Where the float network goes beyond the 131 N that 18 bits of mN hold."""
    counts = np.random.default_rng(SEED).integers(fixed.count_low, fixed.count_high + 1, (N_POSES, 3))
    found, wanted_mn = core(counts, fixed), 1000.0 * network.forces(LEAN.drive.positions(counts))
    is_beyond = np.abs(wanted_mn) > 2**17 + 50
    assert is_beyond.any()
    assert found.saturated[is_beyond].all()
    assert not found.saturated[np.abs(wanted_mn) < 2**17 - 50].any()
    np.testing.assert_array_equal(np.unique(np.abs(found.force_mn[found.saturated] + 0.5)), [2**17 - 0.5])


@pytest.mark.parametrize(
    ("lanes", "interval", "latency", "multipliers"), [(1, 20, 30, 7), (4, 5, 17, 28), (20, 1, 19, 140)]
)
def test_cost_is_below_the_paper_s(lanes, interval, latency, multipliers):
    lean, paper = (CoreCost(20, 3, 3, lanes, is_lean) for is_lean in (True, False))
    assert (lean.multiplications, lean.sums) == (140, 23) < (paper.multiplications, paper.sums) == (166, 43)
    assert (lean.interval, lean.latency, lean.multipliers) == (interval, latency, multipliers)
    assert lean.latency < paper.latency
    assert lean.multipliers < paper.multipliers


def test_counted_lean_form_is_the_network(network):
    position = MACHINE.robot.workspace(1, SEED)[0]
    np.testing.assert_allclose(lean_on_counted(network, position)[0], network.forces(position), rtol=1e-12)


def test_columns_are_rounded_in_turn_and_the_others_fitted_again():
    """Against least squares anew after each; a column of zeros, a neuron that is never active, gets no weight."""
    rng, n, fraction, largest = np.random.default_rng(SEED), 7, 2, 6
    a, y, order = rng.normal(size=(40, n + 1)), rng.normal(size=40), rng.permutation(n)
    a[:, 3] = 0.0
    wanted, rest, free = np.zeros(n + 1), y.copy(), list(range(n + 1))
    for j in order:
        fitted = np.linalg.lstsq(a[:, free], rest, rcond=None)[0][free.index(j)]
        wanted[j] = np.clip(round(4 * fitted), -largest, largest) / 4
        rest = rest - a[:, j] * wanted[j]
        free.remove(j)
    wanted[n] = rest @ a[:, n] / (a[:, n] @ a[:, n])
    np.testing.assert_allclose(_in_order(a, y, order, fraction, largest), wanted, atol=1e-12)
    assert wanted[3] == 0.0
    assert (wanted[:n] != 0.0).any(), "nothing was left of the weights"


def test_form_is_under_the_hash(tmp_path):
    lean = form_copy(SHIPPED, tmp_path, "lean")
    assert folder_hash(lean, load_machine(lean)) != folder_hash(SHIPPED, MACHINE)
    assert MACHINE.with_form("paper").core_facts() == MACHINE.core_facts()


def test_image_is_loaded_by_the_formats_of_the_lean_core(tmp_path):
    lean = form_copy(SHIPPED, tmp_path, "lean")
    image, fixed = load_image(lean, lean), quantised(load_machine(lean), load_network(lean))
    for name, value in vars(fixed).items():
        np.testing.assert_array_equal(getattr(image.network, name), value, err_msg=name)


@pytest.mark.parametrize("given_is_lean", [True, False])
def test_image_for_the_other_form_is_refused(tmp_path, given_is_lean):
    lean = form_copy(SHIPPED, tmp_path, "lean")
    given, rom = (lean, SHIPPED) if given_is_lean else (SHIPPED, lean)
    forms = ("lean", "paper") if given_is_lean else ("paper", "lean")
    told = rf"robot.toml: \[network\] form = '{forms[0]}', but the core was built with '{forms[1]}'; give that"
    with pytest.raises(InputError, match=told):
        load_image(given, rom)


def test_weights_too_large_for_the_lean_core_are_refused(fixed, network):
    larger = replace(network, hidden_weights=2 * network.hidden_weights)
    with pytest.raises(InputError, match=r"hidden.csv: row \d+, column w_q\d, per count code: .* does not fit 18 bits"):
        quantised(LEAN, larger, "weights", fixed)
    stronger = replace(network, f_scale=4 * network.f_scale)
    with pytest.raises(InputError, match=r"output.csv: row \d, column v_\d+, mN per unit of Gamma: .* does not fit"):
        quantised(LEAN, stronger, "weights", fixed)


def test_sin_cos_is_refused_in_the_lean_form(network):
    turning = replace(network, inputs=("sin_cos", "position", "position"))
    with pytest.raises(InputError, match=r"form = 'lean' takes positions alone, not the input sin_cos; give form"):
        quantised(LEAN, turning)


def test_certify_refuses_the_lean_form(fixed):
    with pytest.raises(InputError, match=r"form = 'lean': the paper's form alone is followed; give form = 'paper'"):
        Certifier(LEAN, fixed)


def test_unknown_form_is_refused():
    text = changed(('activation = "gamma"', 'activation = "gamma"\nform = "leaner"'))
    with pytest.raises(InputError, match=r"\[network\] form = 'leaner'; give one of paper, lean, serial"):
        parse_machine(text, str(SHIPPED / "robot.toml"))
