"""Training: scaling, symmetry, reproducibility, weights on the hardware's grid, the command and its error paths."""

import json
import time
from dataclasses import replace

import numpy as np
import pytest

from arm import arm_toml
from gravcomp.cli import main
from gravcomp.core.formats import quantise
from gravcomp.errors import InputError
from gravcomp.network.weights import load_network, save_network
from gravcomp.parallel import one_blas_thread, run_parallel
from gravcomp.robot.machine import load_machine, parse_machine
from gravcomp.robot.spheiro.kinematics import inverse_kinematics
from gravcomp.robot.spheiro.statics import holding_forces
from gravcomp.robot.spheiro.workspace import pose
from gravcomp.training.largest_error import largest_error
from gravcomp.training.levenberg_marquardt import ACTIVATIONS, Problem, Stop, levenberg_marquardt
from gravcomp.training.scaling import effort_scale, workspace_scaling
from gravcomp.training.search import basin_hopping, best_of_draws, random_hidden
from gravcomp.training.symmetry import cyclic_images, cyclic_tie, is_cyclic
from gravcomp.training.training import (
    N_TEST_POSES,
    RIDGE,
    Effort,
    as_network,
    effort_of_size,
    evaluate,
    mean_square_error,
    train,
    workspace_set,
)
from gravcomp.training.waves import waves_of
from machines import MACHINE, SHIPPED, P, changed
from mechanisms import body, mjcf, write_mechanism

ALL = np.ones(3, dtype=bool)  # of three axes
SHORT = Effort(draws=2, tied_hops=2, hops=2, search_poses=100)


def lopsided():
    """A machine without symmetry."""
    return parse_machine(
        changed(("com_m = [0.03464101615137755, 0.03464101615137755", "com_m = [0.03, 0.04")), "lopsided"
    )


@pytest.fixture(scope="module")
def small():
    """A small training set and the network trained on it."""
    data = workspace_set(150, MACHINE.robot, 1)
    return data, *train(data, MACHINE, n_hidden=7, n_starts=2, seed=3, effort=SHORT)


def test_scaling_covers_the_whole_workspace_and_little_more():
    scaling = workspace_scaling(MACHINE)
    azimuth = np.deg2rad(np.arange(0.0, 360.0, 0.3))[:, None, None]
    tilt = np.deg2rad([P.tilt_max_deg - 0.1, P.tilt_max_deg])[:, None]
    torsion = np.deg2rad(np.linspace(-P.torsion_max_deg, P.torsion_max_deg, 53))
    edge = pose(azimuth, tilt, torsion)
    x, y = scaling.x(inverse_kinematics(edge, P)), scaling.y(holding_forces(edge, P))
    assert 0.99 < np.abs(x).max() < 1.0
    assert 0.99 < np.abs(y).max() <= 1.0
    inside = workspace_set(20_000, MACHINE.robot, 11)
    assert np.abs(scaling.x(inside.q)).max() < np.abs(x).max()
    assert np.abs(scaling.y(inside.f)).max() < np.abs(y).max()


def test_nominal_robot_is_cyclic_and_a_lopsided_one_is_not():
    assert is_cyclic(MACHINE.robot)
    assert not is_cyclic(lopsided().robot)


@pytest.mark.parametrize("n_hidden", [1, 3, 7, 20])
def test_tied_network_turns_its_forces_with_the_axes(n_hidden):
    rng = np.random.default_rng(5)
    tie = cyclic_tie(n_hidden, 3)
    parameters = rng.normal(size=tie.max() + 1)[tie]
    hidden, output = np.split(parameters, [4 * n_hidden])
    network = as_network(hidden.reshape(n_hidden, 4), output.reshape(3, n_hidden + 1), workspace_scaling(MACHINE))
    q_m = workspace_set(50, MACHINE.robot, 6).q
    np.testing.assert_allclose(
        network.forces(np.roll(q_m, 1, axis=1)), np.roll(network.forces(q_m), 1, axis=1), rtol=0, atol=1e-9
    )
    n_orbits, n_alone = divmod(n_hidden, 3)
    assert tie.max() + 1 == 7 * n_orbits + 3 * n_alone + 1


def test_cyclic_images_are_poses_of_the_same_robot():
    data = workspace_set(20, MACHINE.robot, 7)
    images = cyclic_images(data.q)
    assert len(images) == 60
    np.testing.assert_array_equal(images[20:40], data.q[:, [2, 0, 1]])


def test_training_repeats_itself_from_its_seed_and_differs_for_another(small):
    data, network, _ = small
    again, _ = train(data, MACHINE, n_hidden=7, n_starts=2, seed=3, backend="threading", effort=SHORT)
    other, _ = train(data, MACHINE, n_hidden=7, n_starts=2, seed=4, effort=SHORT)
    np.testing.assert_array_equal(again.hidden_weights, network.hidden_weights)
    np.testing.assert_array_equal(again.output_bias, network.output_bias)
    assert np.abs(other.hidden_weights - network.hidden_weights).max() > 1e-3


def test_trained_weights_are_exact_in_the_hardware_formats(small):
    data, network, fit = small
    fixed = quantise(network, MACHINE.drive)
    np.testing.assert_array_equal(fixed.hidden_weights * 2.0**-fixed.weight_fraction, network.hidden_weights)
    np.testing.assert_array_equal(fixed.output_weights * 2.0**-fixed.output_weight_fraction, network.output_weights)
    free = as_network(fit.hidden, fit.output, workspace_scaling(MACHINE))
    assert mean_square_error(network, data) < 1.001 * mean_square_error(free, data)


def test_hops_lower_the_cost_and_respect_the_weight_limit(monkeypatch):
    scaling, data = workspace_scaling(MACHINE), workspace_set(150, MACHINE.robot, 1)
    problem = Problem(scaling.x(data.q), scaling.y(data.f), 6, ACTIVATIONS["gamma"], None, RIDGE)
    rng = np.random.default_rng(8)
    drawn = best_of_draws(problem, 5, rng)
    limit = 1.05 * np.abs(drawn.hidden[:, :-1]).max()
    monkeypatch.setattr("gravcomp.training.search.WEIGHT_LIMIT", limit)
    hopped = basin_hopping(problem, drawn, 20, rng)
    assert hopped.cost < drawn.cost
    assert np.abs(hopped.hidden[:, :-1]).max() < limit


def test_one_start_reaches_0_02_within_thirty_cpu_seconds():
    scaling, data = workspace_scaling(MACHINE), workspace_set(3500, MACHINE.robot, 1)
    x, y = scaling.x(data.q), scaling.y(data.f)
    began = time.process_time()
    with one_blas_thread():
        problem = Problem(x, y, 20, ACTIVATIONS["gamma"], cyclic_tie(20, 3), RIDGE)
        fit = levenberg_marquardt(problem, random_hidden(20, 3, np.random.default_rng(1)), Stop(steps=300))
    cpu_s = time.process_time() - began
    mse_n2 = fit.mse * scaling.f_scale[0] ** 2
    print(f"one start: MSE {mse_n2:.4f} N^2 in {cpu_s:.1f} CPU seconds")
    assert mse_n2 <= 0.02
    assert cpu_s <= 30.0  # 15 s on two cores


def test_command_writes_a_folder_that_loads_with_its_provenance(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("gravcomp.training.training.Effort", lambda: SHORT)
    arguments = [
        "--robot",
        str(SHIPPED),
        "--hidden",
        "7",
        "--starts",
        "1",
        "--poses",
        "60",
        "--seed",
        "5",
        "--out",
        str(tmp_path),
    ]
    assert main(["train", *arguments]) == 0
    network = load_network(tmp_path)
    provenance = json.loads((tmp_path / "provenance.json").read_text())
    assert network.n_hidden == 7
    assert provenance["data"]["sha256"] == workspace_set(60, MACHINE.robot, 5).hash()
    figures = evaluate(network, workspace_set(60, MACHINE.robot, 5), workspace_set(8000, MACHINE.robot, 6))
    largest = provenance["metrics"].pop("largest")
    assert provenance["metrics"] == pytest.approx(figures, rel=1e-12)
    assert largest == pytest.approx(largest_error(network, MACHINE.robot, 6), rel=1e-12)
    assert "seed 5" in capsys.readouterr().out


def test_shipped_weights_reach_their_figures_and_the_hardware_formats():
    network = load_network(SHIPPED)
    provenance = json.loads((SHIPPED / "provenance.json").read_text())
    data = workspace_set(provenance["data"]["poses"], MACHINE.robot, provenance["data"]["seed"])
    unseen = workspace_set(N_TEST_POSES, MACHINE.robot, provenance["data"]["test_seed"])
    figures = evaluate(network, data, unseen)
    assert data.hash() == provenance["data"]["sha256"]
    assert figures == pytest.approx(provenance["metrics"], rel=1e-9)
    assert figures["test_mse"] <= 0.0075
    fixed = quantise(network, MACHINE.drive)
    np.testing.assert_array_equal(fixed.hidden_weights * 2.0**-fixed.weight_fraction, network.hidden_weights)
    np.testing.assert_array_equal(fixed.output_weights * 2.0**-fixed.output_weight_fraction, network.output_weights)


def test_lopsided_robot_is_trained_without_symmetry(tmp_path):
    machine = lopsided()
    data = workspace_set(100, machine.robot, 1)
    network, fit = train(data, machine, n_hidden=6, n_starts=1, effort=SHORT)
    save_network(network, tmp_path)
    f_scale_n = workspace_scaling(machine).f_scale[0]
    assert mean_square_error(network, data) == pytest.approx(fit.mse * f_scale_n**2, rel=1e-2)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["--hidden", "0"], "0 hidden neurons"),
        (["--starts", "0"], "0 starts"),
        (["--poses", "0"], "0 poses"),
        (["--poses", "41"], "41 poses for 20 hidden neurons"),
        (["--seed", "-1"], "seed -1"),
        (["--robot", "none"], "none: no robot.toml"),
        (["--backend", "dask"], "DASK_SCHEDULER_ADDRESS is not set"),
        (["--hidden", "8,0"], "0 hidden neurons"),
        (["--largest-error", "-1"], "--largest-error -1"),
        (["--norm", "15"], "--norm 15"),
        (["--hops", "-1"], "--hops -1"),
    ],
)
def test_bad_arguments_end_in_one_line_and_status_2(arguments, named, tmp_path, capfd):
    robot = [] if "--robot" in arguments else ["--robot", str(SHIPPED)]
    assert main(["train", "--out", str(tmp_path), *robot, *arguments]) == 2
    last = capfd.readouterr().err.strip().splitlines()[-1]
    assert last.startswith("gravcomp train: ")
    assert named in last
    assert not list(tmp_path.iterdir())


def test_unwritable_folder_is_an_input_error(tmp_path):
    (tmp_path / "file").write_text("")
    network = train(workspace_set(60, MACHINE.robot, 1), MACHINE, n_hidden=2, n_starts=1, effort=SHORT)[0]
    with pytest.raises(InputError, match="cannot be written"):
        save_network(network, tmp_path / "file")


def test_parallel_runs_keep_their_order():
    assert run_parallel(divmod, [(n, 3) for n in range(7)], "threading", "test") == [divmod(n, 3) for n in range(7)]


def test_scale_leaves_bits_for_all_axes_beside_a_load_that_hardly_changes():
    """A lift with a constant load: y is (f - offset) / scale of every axis in one format, and holds offset / scale."""
    half, middle = np.array([0.1, 15.0]), np.array([39.24, 0.0])
    scale = effort_scale(half, middle, ("m", "rad"))
    assert (np.abs(middle) / scale).max() <= 4.0
    assert scale[1] == 15.0
    assert effort_scale(half, 0 * middle, ("rad", "rad")).tolist() == [15.0, 15.0]


def planar_waves(n_poses: int):
    """The waves of a planar arm of three joints, whose torques are cosines of angles summed from the base."""
    machine = parse_machine(arm_toml(3), "an arm")
    scaling, data = workspace_scaling(machine), workspace_set(n_poses, machine.robot, 1)
    return waves_of(data.q, scaling.y(data.f), scaling, ALL), scaling, data


def test_waves_of_a_planar_arm_are_the_sums_of_its_angles():
    waves, scaling, _ = planar_waves(800)
    found = waves.directions * scaling.q_scale
    found /= np.abs(found).max()
    wanted = np.tril(np.ones((3, 3)))
    largest = found[np.argsort(-waves.shares)[:3]]
    assert sorted(map(tuple, np.round(largest, 9))) == sorted(map(tuple, wanted))
    assert waves.shares.sum() == pytest.approx(1.0)


def test_neurons_along_waves_start_better_than_random_ones():
    waves, scaling, data = planar_waves(400)
    problem = Problem(scaling.x(data.q), scaling.y(data.f), 15, ACTIVATIONS["gamma"], None, RIDGE)
    rng = np.random.default_rng(2)
    along = [problem.at(waves.hidden(15, rng).ravel()).cost for _ in range(5)]
    anywhere = [problem.at(random_hidden(15, 3, rng).ravel()).cost for _ in range(5)]
    assert np.median(along) < 0.5 * np.median(anywhere)


def test_what_is_no_wave_or_turns_by_sine_and_cosine_has_none():
    """Linear axes; efforts that are noise; an axis whose sine and cosine the network sees."""
    spheiro = workspace_set(300, MACHINE.robot, 1)
    assert waves_of(spheiro.q, spheiro.f, workspace_scaling(MACHINE), ALL) is None
    _, scaling, data = planar_waves(400)
    noise = np.random.default_rng(3).standard_normal(data.f.shape)
    assert waves_of(data.q, noise, scaling, ALL) is None
    turning = replace(scaling, inputs=("sin_cos", "position", "position"))
    assert waves_of(data.q, scaling.y(data.f), turning, ALL) is None


def test_a_larger_network_is_searched_as_long_as_a_small_one():
    small, large = effort_of_size(20, 3, 3), effort_of_size(40, 12, 6)
    assert small == Effort()
    assert effort_of_size(20, 3, 3, 0.1) == Effort(draws=6, tied_hops=6, hops=20)
    assert large.search_poses >= 2 * (40 * 13 + 6 * 41)
    cost_of = lambda effort, columns: effort.hops * effort.search_poses * columns**2  # noqa: E731
    assert cost_of(large, 40 * 14 + 1) < 2.5 * cost_of(small, 101)


def test_a_network_for_which_a_hop_is_too_long_is_drawn_twice_and_polished():
    """One hop, 40 and 100 steps on the poses of the search, against all the time of the usual one."""
    seven = effort_of_size(128, 6, 7)
    steps = lambda effort, columns: effort.search_poses * columns**2  # noqa: E731
    usual = Effort()
    assert steps(seven, 128 * 8 + 1) > usual.hops * steps(usual, 101)
    assert (seven.draws, seven.tied_hops, seven.hops) == (2, 0, 0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('mass="2.0"', 'mass="1e30"', "no core holds its ranges and efforts (axis 1, column f_scale is too large"),
        ('mass="2.0"', 'mass="1e-9"', "no core holds its ranges and efforts (axis 1, column f_scale is too"),
        (
            "counts_per_turn = 100000",
            "counts_per_turn = 100000000000000",
            "no core holds its ranges and efforts (axis 1, column q_scale: the",
        ),
        ("effort_per_ampere = 10.0", "effort_per_ampere = 1e-30", "axis 1: effort_per_ampere is too large or small"),
    ],
)
def test_machine_that_no_core_holds_is_refused_before_its_training(tmp_path, old, new, said):
    folder = write_mechanism(tmp_path, mjcf(body("a", 'name="j" axis="0 1 0" range="-1 1"', 2.0, "0.1 0 0")), {"j": ""})
    for file in (folder / "robot.xml", folder / "robot.toml"):
        file.write_text(file.read_text().replace(old, new))
    machine = load_machine(folder)
    data = workspace_set(50, machine.robot, 1)
    with pytest.raises(InputError) as refused:
        train(data, machine, n_hidden=2, n_starts=1, effort=None)  # which would be asked for the first draw
    assert str(refused.value).startswith(f"{folder / 'robot.toml'}: ")
    assert said in str(refused.value)
