"""Training: from the robot's statics to a network: data, search, polish, weights on the hardware's grid.

Two rounds of independent, seeded searches on part of the poses: random starts with weights tied by the robot's
symmetry, where it has one, then hops from the best of them with all weights free. The best is polished on all poses;
its weights are snapped to the 18-bit codes of the hardware and the output layer is solved again.
"""

import hashlib
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from gravcomp.core.formats import quantise
from gravcomp.errors import InputError
from gravcomp.network.inputs import axis_of_input
from gravcomp.network.weights import SCALING_CSV, Network
from gravcomp.parallel import one_blas_thread, run_parallel
from gravcomp.robot.machine import ROBOT_TOML, Drive, Machine
from gravcomp.robot.protocol import HasRows, Robot
from gravcomp.training import POLISH_STEPS
from gravcomp.training.felt_axes import felt_axes
from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Problem, Stop, Trained, levenberg_marquardt
from gravcomp.training.scaling import Scaling, workspace_scaling
from gravcomp.training.search import basin_hopping, best_of_draws
from gravcomp.training.symmetry import cyclic_images, cyclic_tie, is_cyclic
from gravcomp.training.waves import waves_of

# Small against the error that 20 neurons leave, large enough that output weights cannot grow without bound.
RIDGE = 1e-9
N_TEST_POSES = 8000
_POLISH_STALL = 1e-5
_BASE_COLUMNS, _FEWEST_DRAWS = 101, 2  # of 3-20-3
_FEWEST_POSES, _POSES_PER_PARAMETER = 3500, 4


@dataclass(frozen=True)
class TrainingSet:
    """Poses with their holding efforts: q (N, n), m or rad; f (N, n), N or Nm."""

    q: np.ndarray
    f: np.ndarray

    def hash(self) -> str:
        """SHA-256 of the set in whole nanometres or nanoradians and micronewtons: the same on every machine."""
        codes = np.rint(np.c_[self.q * 1e9, self.f * 1e6]).astype("<i8")
        return hashlib.sha256(codes.tobytes()).hexdigest()


@dataclass(frozen=True)
class Effort:
    """How hard one start searches: draws and tied hops in the first round, free hops in the second.

    All on the first search_poses poses. Without symmetry nothing is tied and both kinds of hops are the same.
    """

    draws: int = 60
    tied_hops: int = 60
    hops: int = 200
    search_poses: int = 600


def effort_of_size(n_hidden: int, n_inputs: int, n_outputs: int, part: float = 1.0) -> Effort:
    """As much time whatever the size: a larger network needs more poses and gets fewer draws and hops.

    part: of that time. A step costs poses times the square of the Jacobian's columns. A network too large for a hop in
    its share of that time gets none: what a hop costs there is better spent on the polish.
    """
    base, columns = Effort(), n_hidden * (n_inputs + 2) + 1
    poses = max(base.search_poses, 2 * n_parameters(n_hidden, n_inputs, n_outputs))
    share = part * min(1.0, _BASE_COLUMNS**2 * base.search_poses / (columns**2 * poses))
    if share == 1.0:
        return base
    draws, tied_hops, hops = (round(share * n) for n in (base.draws, base.tied_hops, base.hops))
    return replace(base, draws=max(_FEWEST_DRAWS, draws), tied_hops=tied_hops, hops=hops, search_poses=poses)


def n_felt_inputs(machine: Machine) -> int:
    """Inputs that a network of the machine looks at."""
    return int(felt_axes(machine.robot)[axis_of_input(machine.inputs)].sum())


def n_parameters(n_hidden: int, n_inputs: int, n_outputs: int) -> int:
    return n_hidden * (n_inputs + 1) + n_outputs * (n_hidden + 1)


def poses_of_size(n_hidden: int, n_inputs: int, n_outputs: int) -> int:
    """Training poses that a network of this size does not learn by heart."""
    return max(_FEWEST_POSES, _POSES_PER_PARAMETER * n_parameters(n_hidden, n_inputs, n_outputs))


def workspace_set(n_poses: int, robot: Robot, seed: int) -> TrainingSet:
    """n_poses random poses of the workspace. Raises InputError when n_poses is below 1 or seed below 0."""
    _check_request(n_poses, seed)
    q = robot.workspace(n_poses, seed)
    return TrainingSet(q, robot.forces(q))


def training_and_test_set(n_poses: int, robot: Robot, seed: int) -> tuple[TrainingSet, TrainingSet]:
    """n_poses random poses of the workspace, and N_TEST_POSES other ones.

    Of a workspace that is a list at most so many of its rows, a fifth of all for the test. Raises InputError, also
    where no axis bears a load.
    """
    rows = robot.rows if isinstance(robot, HasRows) else None
    if rows is None:
        data, unseen = workspace_set(n_poses, robot, seed), workspace_set(N_TEST_POSES, robot, seed + 1)
    else:
        data, unseen = _split(rows, n_poses, robot, seed)
    if not data.f.any():
        raise InputError(f"no axis bears a load at any of {len(data.q)} poses: nothing is to be held; correct the "
                         "robot's gravity or masses")  # fmt: skip
    return data, unseen


def _split(rows: np.ndarray, n_poses: int, robot: Robot, seed: int) -> tuple[TrainingSet, TrainingSet]:
    """At most n_poses of all poses rows (N, n), and a fifth of them for the test. Raises InputError."""
    _check_request(n_poses, seed)
    n_test = min(N_TEST_POSES, len(rows) // 5)
    if n_test < 1:
        raise InputError(f"{len(rows)} poses in the workspace; give at least 5, a fifth is for the test")
    order = np.random.default_rng(seed).permutation(len(rows))
    test, rest = rows[order[:n_test]], rows[order[n_test : n_test + n_poses]]
    return TrainingSet(rest, robot.forces(rest)), TrainingSet(test, robot.forces(test))


def train(
    data: TrainingSet,
    machine: Machine,
    *,
    n_hidden: int = 20,
    n_starts: int = 4,
    seed: int = 1,
    activation: str = "gamma",
    backend: str = "loky",
    polish: int = POLISH_STEPS,
    effort: Effort,
) -> tuple[Network, Trained]:
    """The best network of n_starts searches per round, on the hardware's grid, and its fit in normalised units.

    Chosen by training error alone. polish: steps of the best on all poses, at most. Raises InputError for sizes below
    1, too few poses, or a backend that is absent.
    """
    check_size(data, n_hidden, n_starts)
    scaling = workspace_scaling(machine)
    check_core_holds(machine, scaling)
    x, y = scaling.x(data.q), scaling.y(data.f)
    axes = felt_axes(machine.robot)
    felt = axes[axis_of_input(machine.inputs)]
    symmetric = is_cyclic(machine.robot) and scaling.is_uniform
    waves = waves_of(data.q, y, scaling, axes)
    seeds = np.random.SeedSequence(seed).spawn(2 * n_starts)
    common = (x[: effort.search_poses, felt], y[: effort.search_poses], n_hidden, activation, symmetric, effort, waves)
    first = run_parallel(draw_start, [(*common, s) for s in seeds[:n_starts]], backend, f"{n_hidden} neurons, starts")
    best = min(first, key=lambda fit: fit.cost)
    second = run_parallel(hop_on, [(*common, best, s) for s in seeds[n_starts:]], backend, f"{n_hidden} neurons, hops")
    best = min(second, key=lambda fit: fit.cost)
    problem = _problem(x[:, felt], y, n_hidden, activation, symmetric)
    with one_blas_thread():
        fit = levenberg_marquardt(problem, best.hidden, Stop(steps=polish, stall=_POLISH_STALL))
    fit = replace(fit, hidden=_of_all_inputs(fit.hidden, felt))
    return snapped(fit, _problem(x, y, n_hidden, activation, symmetric), scaling, machine.drive), fit


def check_core_holds(machine: Machine, scaling: Scaling) -> None:
    """Raise InputError, before the training and not after it, where no network of these ranges and efforts fits."""
    nothing = as_network(np.zeros((1, len(axis_of_input(machine.inputs)) + 1)), np.zeros((machine.n_axes, 2)), scaling)
    try:
        quantise(nothing, machine.drive, Path(machine.where).parent)
    except InputError as error:
        if ROBOT_TOML in str(error):
            raise
        _, _, reason = str(error).partition(f"{SCALING_CSV}: ")
        raise InputError(f"{machine.where}: no core holds its ranges and efforts ({reason.replace('row', 'axis', 1)}); "
                         "correct the masses, lengths, ranges or counts that they follow from") from error  # fmt: skip


def _of_all_inputs(hidden: np.ndarray, felt: np.ndarray) -> np.ndarray:
    """[W b_H] (h, p+1) of hidden parameters over those inputs (p,) alone that are felt."""
    whole = np.zeros((len(hidden), len(felt) + 1))
    whole[:, np.r_[felt, True]] = hidden
    return whole


def draw_start(x, y, n_hidden: int, activation: str, symmetric: bool, effort: Effort, waves, seed) -> Trained:
    """First round: random draws, then hops, with weights tied by the symmetry where there is one."""
    rng = np.random.default_rng(seed)
    tie = cyclic_tie(n_hidden, y.shape[1]) if symmetric else None
    problem = Problem(x, y, n_hidden, ACTIVATIONS[activation], tie, RIDGE)
    return basin_hopping(problem, best_of_draws(problem, effort.draws, rng, waves), effort.tied_hops, rng, waves)


def hop_on(x, y, n_hidden: int, activation: str, symmetric: bool, effort: Effort, waves, fit: Trained, seed) -> Trained:
    """Second round: hops from the best of the first with all weights free."""
    problem = _problem(x, y, n_hidden, activation, symmetric)
    return basin_hopping(problem, fit, effort.hops, np.random.default_rng(seed), waves)


def snapped(fit: Trained, problem: Problem, scaling: Scaling, drive: Drive) -> Network:
    """The network with W and V on the hardware's grid: each layer is rounded, then what follows it is solved again.

    Raises InputError when the hardware cannot hold the weights.
    """
    fixed = quantise(as_network(fit.hidden, fit.output, scaling), drive)
    hidden = np.c_[fixed.hidden_weights * 2.0**-fixed.weight_fraction, fit.hidden[:, -1]]
    point = problem.at(hidden.ravel())
    fixed = quantise(as_network(hidden, point.output, scaling), drive)
    weights = fixed.output_weights * 2.0**-fixed.output_weight_fraction
    bias = (problem.y - point.act[:, :-1] @ weights.T).mean(axis=0)
    return as_network(hidden, np.c_[weights, bias], scaling)


def as_network(hidden: np.ndarray, output: np.ndarray, scaling: Scaling) -> Network:
    """A Network from [W b_H], [V b_o] and the scaling."""
    return Network(hidden[:, :-1], hidden[:, -1], output[:, :-1], output[:, -1], **vars(scaling))


def mean_square_error(network: Network, data: TrainingSet, activation: str = "gamma") -> float:
    """Mean over poses and axes of the squared error of the effort."""
    error = network.forces(data.q, ACTIVATIONS[activation].value) - data.f
    return float(np.mean(error**2))


def evaluate(network: Network, data: TrainingSet, unseen: TrainingSet, activation: str = "gamma") -> dict[str, float]:
    """Figures of a network on its training poses and on unseen ones; errors in N or Nm, weights without unit."""
    error = network.forces(unseen.q, ACTIVATIONS[activation].value) - unseen.f
    return {
        "train_mse": mean_square_error(network, data, activation),
        "test_mse": float(np.mean(error**2)),
        "test_rms": float(np.sqrt(np.mean(error**2))),
        "test_max": float(np.abs(error).max()),
        "test_rms_percent": 100.0 * float(np.sqrt(np.mean(error**2) / np.mean(unseen.f**2))),
        "max_hidden_weight": float(np.abs(network.hidden_weights).max()),
        "max_output_weight": float(np.abs(network.output_weights).max()),
    }


def _problem(x, y, n_hidden: int, activation: str, symmetric: bool) -> Problem:
    """All parameters free; a symmetric robot gives every pose n times, once from each axis."""
    if symmetric:
        x, y = cyclic_images(x), cyclic_images(y)
    return Problem(x, y, n_hidden, ACTIVATIONS[activation], None, RIDGE)


def _check_request(n_poses: int, seed: int) -> None:
    if n_poses < 1:
        raise InputError(f"{n_poses} poses; give at least 1")
    if seed < 0:
        raise InputError(f"seed {seed} is negative; give 0 or more")


def check_size(data: TrainingSet, n_hidden: int, n_starts: int) -> None:
    """Raises InputError for sizes below 1, or too few poses."""
    for name, value in (("hidden neurons", n_hidden), ("starts", n_starts)):
        if value < 1:
            raise InputError(f"{value} {name}; give at least 1")
    n_needed = 2 * n_hidden + 2  # as many equations as parameters, with some to spare
    if len(data.q) < n_needed:
        raise InputError(f"{len(data.q)} poses for {n_hidden} hidden neurons; give at least {n_needed}")
