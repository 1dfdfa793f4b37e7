"""The certified error: its bound holds at every pose tried, a false claim is refused, unsound rules are caught."""

from dataclasses import replace

import numpy as np
import pytest

from codes import ROOT
from gravcomp.certify import core as enclosure
from gravcomp.certify.branch import Boxes, branch_and_bound
from gravcomp.certify.certificate import Certifier, certify
from gravcomp.certify.core import core_forces
from gravcomp.certify.report import upward
from gravcomp.certify.search import WorstPose
from gravcomp.certify.taylor import Taylor
from gravcomp.cli import main
from gravcomp.core import formats as q
from gravcomp.core.folder import load_folder
from gravcomp.core.formats import quantise
from gravcomp.network.activation import gamma
from gravcomp.network.weights import Network
from gravcomp.robot.machine import Drive, load_machine
from gravcomp.robot.spheiro.workspace import pose
from gravcomp.twin import network as bittrue

SEED = 5
CERTIFIED = ["spheiro", "slide", "arm2", "so101", "ur5"]


def certifier(name: str) -> Certifier:
    content = load_folder(ROOT / "weights" / name)
    return Certifier(content.machine, quantise(content.network, content.machine.drive))


def drawn(certified: Certifier, n_poses: int) -> np.ndarray:
    """Parameters (n_poses, k): a third inside, a third with some on the boundary, a third on edges and corners."""
    rng, formula = np.random.default_rng(SEED), certified.formula
    at = rng.uniform(formula.low, formula.high, (n_poses, len(formula.low)))
    ends = np.where(rng.random(at.shape) < 0.5, formula.low, formula.high)
    is_end = rng.random(at.shape) < np.repeat([0.0, 0.4, 0.9], -(-n_poses // 3))[:n_poses, None]
    return np.where(is_end, ends, at)


@pytest.fixture(scope="module")
def spheiro():
    certified = certifier("spheiro")
    return certified, certify(certified, 0.01, None, 600.0, SEED)


def test_the_bound_holds_at_100000_poses_and_the_boundary(spheiro):
    certified, certificate = spheiro
    assert certificate.is_complete
    assert (np.abs(certified.errors(drawn(certified, 100_000))) <= certificate.bounded.bound).all()


def test_the_poses_are_those_of_the_robot_and_its_bit_true_core(spheiro):
    certified, _ = spheiro
    machine, at = certified.machine, drawn(certified, 2000)
    q_m = certified.formula.at(at)[0]
    core_n = bittrue.core(machine.drive.counts(q_m), certified.fixed).force_mn * 1e-3
    np.testing.assert_allclose(certified.errors(at), core_n - machine.robot.forces(q_m), atol=1e-9)
    rotation = pose(*at.T)
    np.testing.assert_allclose(
        rotation @ np.swapaxes(rotation, -1, -2), np.broadcast_to(np.eye(3), rotation.shape), atol=1e-14
    )


def test_the_bound_is_within_ten_percent_of_the_largest_error_found(spheiro):
    _, certificate = spheiro
    assert (certificate.bounded.bound <= 1.1 * certificate.found.size).all()
    assert (certificate.bounded.bound >= certificate.found.size).all()


def test_a_claim_below_the_largest_error_is_refused_with_pose_and_box(spheiro, capsys):
    certified, certificate = spheiro
    claim = 0.95 * certificate.found.size.max()
    assert main(["certify", str(ROOT / "weights" / "spheiro"), "--bound", str(claim)]) == 2
    complaint = capsys.readouterr().err.splitlines()[-1]
    q_m = np.array([float(value) for value in complaint.split("(")[1].split(")")[0].split(",")])
    machine = certified.machine
    error = bittrue.core(machine.drive.counts(q_m), certified.fixed).force_mn * 1e-3 - machine.robot.forces(q_m)
    assert np.abs(error).max() > claim
    sides = [part.split()[-3:] for part in complaint.split("every pose of ")[1].split(";")[0].split(", ")]
    low, high = (np.array([float(side[k]) for side in sides]) for k in (0, 2))
    inside = np.random.default_rng(SEED).uniform(low, high, (5000, 3))
    assert (np.abs(certified.errors(inside)).max(axis=1) > claim).all()


def test_a_claim_that_no_arithmetic_here_can_decide_is_neither_proven_nor_broken(spheiro, capsys):
    _, certificate = spheiro
    claim = certificate.found.size.max() * 1.001
    assert main(["certify", str(ROOT / "weights" / "spheiro"), "--bound", str(claim)]) == 2
    assert "not proven, nor broken" in capsys.readouterr().err


def test_a_claim_that_holds_is_proven(spheiro, capsys):
    _, certificate = spheiro
    claim = certificate.bounded.bound.max() * 1.05
    assert main(["certify", str(ROOT / "weights" / "spheiro"), "--bound", str(claim)]) == 0
    proven = float(capsys.readouterr().out.split("<= ")[1].split()[0])
    assert certificate.found.size.max() <= proven <= claim + 1e-4


def test_when_the_time_is_up_what_is_proven_still_holds():
    certified = certifier("spheiro")
    certificate = certify(certified, 0.01, None, 1.5, SEED)
    assert not certificate.is_complete
    assert (np.abs(certified.errors(drawn(certified, 5000))) <= certificate.bounded.bound).all()


@pytest.mark.parametrize("name", CERTIFIED)
def test_boxes_of_every_size_hold_the_errors_of_their_poses(name):
    certified = certifier(name)
    rng, formula = np.random.default_rng(SEED), certified.formula
    for size in (0.3, 0.1, 0.03, 0.003, 0.0):
        centre = drawn(certified, 400)
        half = size * (formula.high - formula.low)
        low, high = np.maximum(centre - half, formula.low), np.minimum(centre + half, formula.high)
        least, most, _ = certified.enclosed(low.T, high.T)
        for _ in range(5):
            error = certified.errors(rng.uniform(low, high)).T
            assert not ((error < least) | (error > most)).any()  # no number: no bound


@pytest.mark.parametrize("name", ["slide", "arm2", "so101", "ur5"])
def test_the_formula_of_a_serial_chain_is_its_statics(name):
    robot = load_machine(ROOT / "weights" / name).robot
    formula = robot.formula()
    at = np.random.default_rng(SEED).uniform(formula.low, formula.high, (200, robot.n_axes))
    q_m, effort = formula.at(at)
    np.testing.assert_array_equal(q_m, at)
    np.testing.assert_allclose(effort, robot.forces(at), atol=1e-9)


def test_a_closed_chain_is_refused_in_one_line(capsys):
    assert main(["certify", str(ROOT / "weights" / "fivebar")]) == 2
    complaint = capsys.readouterr().err
    assert "closed by iteration" in complaint
    assert complaint.count("\n") == 1


@pytest.mark.parametrize(
    "option", [["--bound", "0"], ["--bound", "nan"], ["--gap", "-1"], ["--minutes", "inf"], ["--seed", "-1"]]
)
def test_an_option_without_meaning_is_refused(option, capsys):
    assert main(["certify", str(ROOT / "weights" / "spheiro"), *option]) == 2
    assert option[0] in capsys.readouterr().err


# The core alone, stage by stage: random networks over positions that reach beyond clamp and saturation.


def random_core(seed: int):
    rng = np.random.default_rng(seed)
    n, h = int(rng.integers(1, 5)), int(rng.integers(1, 12))
    network = Network(
        rng.uniform(-4, 4, (h, n)), rng.uniform(-3, 3, h), rng.uniform(-2, 2, (n, h)), rng.uniform(-1, 1, n),
        rng.uniform(-0.1, 0.1, n), rng.uniform(3, 8, n), rng.uniform(-60, 60, n), rng.uniform(30, 80, n), ("m",) * n,
    )  # fmt: skip
    drive = Drive(10.0 ** rng.uniform(4, 6, n), np.full(n, 45.0), 40e6)
    return network, drive, quantise(network, drive), rng


def positions(network: Network, size: float, rng, n_boxes: int = 300):
    """Boxes low, high (n, n_boxes), m, up to 20 % beyond the trained range, and a position in each."""
    centre = network.q_offset[:, None] + rng.uniform(-1.2, 1.2, (network.n_axes, n_boxes)) / network.q_scale[:, None]
    half = size / network.q_scale[:, None]
    low, high = centre - half, centre + half
    at = np.where(rng.random(low.shape) < 0.5, rng.uniform(low, high), np.where(rng.random(low.shape) < 0.5, low, high))
    return low, high, at


def escaped(seed: int, size: float) -> int:
    """Forces of the core that leave their model's bounds."""
    network, drive, fixed, rng = random_core(seed)
    low, high, at = positions(network, size, rng)
    force = bittrue.core(drive.counts(at.T), fixed).force_mn * 1e-3
    bounds = [model.bounds() for model in core_forces(Taylor.variables(low, high), fixed, drive).forces]
    return sum(int(((force[:, k] < low) | (force[:, k] > high)).sum()) for k, (low, high) in enumerate(bounds))


@pytest.mark.parametrize("size", [0.0, 1e-3, 0.05, 0.5])
@pytest.mark.parametrize("seed", range(8))
def test_forces_of_any_core_stay_in_their_models(seed, size):
    assert escaped(seed, size) == 0


def test_codes_of_the_inputs_stay_within_their_error():
    for seed in range(8):
        assert inputs_outside(seed) == 0


def inputs_outside(seed: int) -> int:
    network, drive, fixed, rng = random_core(seed)
    *_, at = positions(network, 0.0, rng, 5000)
    x, error = enclosure._inputs(Taylor.variables(at, at), fixed, drive)
    code = np.ldexp(bittrue.input_scaler(drive.counts(at.T), fixed)[0].T.astype(float), -fixed.x_fraction)
    return int((np.abs(code - x.constant) > error + x.radius).sum())


def turns_outside() -> int:
    """Sine and cosine of an axis that turns: codes at random positions against their error."""
    machine = load_folder(ROOT / "weights" / "ur5")
    fixed = quantise(machine.network, machine.machine.drive)
    at = np.random.default_rng(SEED).uniform(-np.pi, np.pi, (fixed.n_axes, 20000))
    x, error = enclosure._inputs(Taylor.variables(at, at), fixed, machine.machine.drive)
    code = bittrue.input_stage(machine.machine.drive.counts(at.T), fixed)[0].T
    return int((np.abs(np.ldexp(code.astype(float), -fixed.x_fraction) - x.constant) > error + x.radius).sum())


def test_codes_of_sine_and_cosine_stay_within_their_error():
    assert turns_outside() == 0


def activation_outside() -> int:
    """Over all codes of a: Gamma by the hardware, less Gamma, against the interval of the truncations."""
    code = np.arange(-(2 ** (q.OPERAND_BITS - 1)), 2 ** (q.OPERAND_BITS - 1))
    a = np.ldexp(code.astype(float), -q.PREACTIVATION_FRACTION)
    middle, error = enclosure._truncated_products(a, a)
    away = np.ldexp(bittrue.activation(code).astype(float), -q.HIDDEN_FRACTION) - gamma(a) - middle
    return int((np.abs(away) > error).sum())


def test_every_code_of_the_activation_stays_within_its_truncations():
    assert activation_outside() == 0


def ramps_outside() -> int:
    rng = np.random.default_rng(SEED)
    low = rng.uniform(-3, 3, 2000)
    high = low + 10.0 ** rng.uniform(-6, 0.7, 2000)
    s2, s1, s0, error = enclosure._ramp_squared(low, high)
    s = np.linspace(low, high, 101)
    return int((np.abs(np.maximum(s, 0.0) ** 2 - (s2 * s**2 + s1 * s + s0)) > error + 1e-12).sum())


def test_the_square_of_a_ramp_stays_within_its_error():
    assert ramps_outside() == 0


def test_a_sum_of_ramps_is_gamma():
    a = np.linspace(-4, 4, 1001)
    ramps = sum(w * np.maximum(a - k, 0.0) ** 2 for k, w in zip(enclosure._KNOTS, enclosure._WEIGHTS, strict=True))
    np.testing.assert_allclose(ramps - 1.0, gamma(a), atol=1e-14)


def slopes_outside() -> int:
    rng = np.random.default_rng(SEED)
    low = rng.uniform(-3, 3, 2000)
    high = low + rng.uniform(0, 2, 2000)
    least, most = enclosure._slopes(low, high)
    slope = np.maximum(1.0 - np.abs(np.linspace(low, high, 101)) / 2, 0.0)
    return int(((slope < least - 1e-12) | (slope > most + 1e-12)).sum())


def test_slopes_of_gamma_stay_within_theirs():
    assert slopes_outside() == 0


def scaled(rule: str, which: int, factor: float):
    """A rule whose result, or one of whose results, is wrong by a factor."""
    right = getattr(enclosure, rule)

    def wrong(*arguments):
        results = right(*arguments)
        if not isinstance(results, tuple):
            return results * factor
        return tuple(value * factor if k == which else value for k, value in enumerate(results))

    return wrong


def every_core() -> int:
    return sum(escaped(seed, size) for seed in range(8) for size in (0.0, 1e-3, 0.05))


UNSOUND = {  # rule, which of its results, factor; what must see it
    "errors of the inputs at nine tenths": ("_inputs", 1, 0.9, lambda: sum(map(inputs_outside, range(8)))),
    "errors of sine and cosine at a half": ("_inputs", 1, 0.5, turns_outside),
    "truncations of Gamma at nine tenths": ("_truncated_products", 1, 0.9, activation_outside),
    "truncations of Gamma not centred": ("_truncated_products", 0, 0.0, activation_outside),
    "bends at nine tenths": ("_ramp_squared", 3, 0.9, ramps_outside),
    "bends left out": ("_ramp_squared", 3, 0.0, every_core),
    "a slope too small": ("_slopes", 1, 0.9, slopes_outside),
    "the inputs' errors go nowhere": ("_through_inputs", None, 0.0, every_core),
}


@pytest.mark.parametrize("name", UNSOUND)
def test_an_unsound_rule_is_caught(name, monkeypatch):
    rule, which, factor, look = UNSOUND[name]
    monkeypatch.setattr(enclosure, rule, scaled(rule, which, factor))
    assert look() > 0


# Branch and bound, and the search.


def parabola(low, high):
    """Boxes of the errors x^2 - 0.5 y^2 by interval arithmetic."""
    (x0, y0), (x1, y1) = low, high
    square = lambda a, b: (np.where((a < 0) & (b > 0), 0.0, np.minimum(a * a, b * b)), np.maximum(a * a, b * b))  # noqa: E731
    (xl, xh), (yl, yh) = square(x0, x1), square(y0, y1)
    bound = np.maximum(np.abs(xh - 0.5 * yl), np.abs(xl - 0.5 * yh))[None]
    return Boxes(low, high, bound, (high - low).argmax(axis=0))


def test_branch_and_bound_finds_a_known_maximum():
    low, high = np.array([-1.0, -2.0]), np.array([0.7, 1.0])
    done = branch_and_bound(parabola, lambda: np.array([2.02]), low, high, 60.0)
    assert done.open is None
    assert 2.0 <= done.bound[0] <= 2.02  # at x = 0, y = -2


def test_what_is_not_proven_is_told_with_its_box():
    low, high = np.array([-1.0, -2.0]), np.array([0.7, 1.0])
    done = branch_and_bound(parabola, lambda: np.array([1.5]), low, high, 0.2)
    assert done.bound[0] >= 2.0
    # At x = 0, y = -2 or so near that no box is worse: how small the boxes are when the time is over, nobody knows.
    assert done.open.low[0, 0] <= 1e-3
    assert done.open.high[0, 0] >= -1e-3
    assert done.open.low[1, 0] == -2.0


def test_halves_make_up_their_box():
    boxes = Boxes(np.zeros((2, 3)), np.full((2, 3), 2.0), np.ones((1, 3)), np.array([0, 1, 0]))
    low, high = boxes.halves()
    np.testing.assert_array_equal(high[:, :3] - low[:, :3], [[1, 2, 1], [2, 1, 2]])
    np.testing.assert_array_equal(low[:, 3:], [[1, 0, 1], [0, 1, 0]])
    np.testing.assert_array_equal(high[:, 3:], 2.0)


def test_the_search_climbs_to_a_corner_and_repeats_with_its_seed():
    low, high = np.zeros(3), np.ones(3)
    found = [WorstPose(lambda at: at @ np.diag([1.0, -2.0, 3.0]), low, high) for _ in range(2)]
    for one in found:
        one.search(1000, SEED)
    np.testing.assert_allclose(found[0].size, [1.0, 2.0, 3.0], rtol=1e-4)
    np.testing.assert_array_equal(found[0].parameters, found[1].parameters)


@pytest.mark.parametrize(
    ("value", "text"), [(1.234561, "1.23457"), (1.23456, "1.23456"), (0.0, "0.00000"), (np.inf, "inf")]
)
def test_a_bound_is_never_printed_below_itself(value, text):
    assert upward(value) == text


def test_another_core_has_another_bound():
    """A weight of the ROM that is wrong by one eighth is seen."""
    certified = certifier("arm2")
    weights = certified.fixed.output_weights.copy()
    weights[0, 0] += weights[0, 0] >> 3
    wrong = Certifier(certified.machine, replace(certified.fixed, output_weights=weights))
    good, bad = (certify(one, 0.05, None, 60.0, SEED).bounded.bound[0] for one in (certified, wrong))
    assert bad > good
    assert (np.abs(wrong.errors(drawn(wrong, 5000)))[:, 0] <= bad).all()
