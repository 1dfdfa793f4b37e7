"""The operations of one inference, counted in the running VHDL: 166 multiplications and 43 sums at hidden size 20."""

from pathlib import Path

import pytest

from codes import weights_under_test
from gravcomp.network.weights import load_network
from gravcomp_lab.benches.budget import budget_run
from gravcomp_lab.paper.operations import OperationCount, lean_on_counted
from machines import rtl_of, shipped_in
from runner import BUILD, ROOT, RTL
from support.ghdl import walks_the_hierarchy


def expected(weights: Path, lanes: int) -> tuple[dict[str, int], dict[str, int]]:
    """Of p features, n neurons with what pads them, m axes; those of sines and cosines apart."""
    network = load_network(weights)
    p, m = network.hidden_weights.shape[1], network.n_axes
    n, n_turns = network.n_hidden + -network.n_hidden % lanes, p - m  # two features each
    return (
        {"multiplications": p + p * n + 2 * n + n * m + m, "sums": 2 * n + m},
        {"multiplications": 5 * n_turns, "sums": 3 * n_turns},
    )


def test_network_of_the_paper_takes_166_multiplications_and_43_sums():
    assert expected(ROOT / "weights" / "spheiro", 4)[0] == {"multiplications": 166, "sums": 43}


@walks_the_hierarchy
@pytest.mark.parametrize("lanes", [1, 4])
def test_lean_form_runs_the_operations_of_its_formula(lanes):
    """p n + n + n m multiplications and n + m sums: no scale, one product in Gamma; its NumPy counts as many."""
    weights, generated = shipped_in("lean")
    network = load_network(weights)
    assert lean_on_counted(network, network.q_offset)[1] == OperationCount(multiplications=140, sums=23)
    assert budget_run(lanes, RTL, BUILD / "lean", weights, generated)[0] == {"multiplications": 140, "sums": 23}


@pytest.mark.parametrize("lanes", [1, 4])
def test_core_runs_the_budgeted_operations(lanes):
    weights = weights_under_test()
    assert budget_run(lanes, RTL, BUILD, weights) == expected(weights, lanes)


@walks_the_hierarchy
@pytest.mark.slow
@pytest.mark.parametrize(("name", "lanes"), [("arm2", 3), ("ur5", 1), ("ur5", 4)])
def test_core_of_a_shipped_machine_runs_the_operations_of_the_formula(name, lanes, tmp_path):
    weights = ROOT / "weights" / name
    assert budget_run(lanes, rtl_of(weights, tmp_path / "rtl"), tmp_path, weights) == expected(weights, lanes)
