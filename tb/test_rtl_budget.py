"""The operations of one inference, counted in the running VHDL: 166 multiplications and 43 sums at hidden size 20."""

import subprocess

import pytest

from codes import weights_under_test
from gravcomp.network.weights import load_network
from gravcomp_lab.benches.budget import budget_run
from gravcomp_lab.paper.operations import count_network_operations
from machines import rtl_of
from runner import BUILD, ROOT, RTL

# The bench finds multipliers by iterating over what an instance holds: names inside generates are found no other way.
VERSION = subprocess.run(["ghdl", "--version"], capture_output=True, text=True, check=True).stdout
pytestmark = pytest.mark.skipif(
    "GHDL 5.0.1" in VERSION, reason="GHDL 5.0.1 dies of iterating over gc_hidden_lane (grt-avhpi.adb:732)"
)


@pytest.mark.parametrize("lanes", [1, 4])
def test_core_runs_the_budgeted_operations(lanes):
    total, apart = budget_run(lanes, RTL, BUILD, weights_under_test())
    counted, _ = count_network_operations(load_network(ROOT / "weights" / "spheiro"))
    assert total == {"multiplications": counted.multiplications, "sums": counted.sums}
    assert total == {"multiplications": 166, "sums": 43}
    assert apart == {"multiplications": 0, "sums": 0}


@pytest.mark.slow
@pytest.mark.parametrize(("name", "lanes"), [("arm2", 3), ("ur5", 1), ("ur5", 4)])
def test_core_of_a_shipped_machine_runs_the_operations_of_the_formula(name, lanes, tmp_path):
    """p features, n neurons, m axes; sines and cosines apart; n with what pads it."""
    weights = ROOT / "weights" / name
    network = load_network(weights)
    total, apart = budget_run(lanes, rtl_of(weights, tmp_path / "rtl"), tmp_path, weights)
    p, m = network.hidden_weights.shape[1], network.n_axes
    n = network.n_hidden + -network.n_hidden % lanes
    assert total == {"multiplications": p + p * n + 2 * n + n * m + m, "sums": 2 * n + m}
    n_turns = p - m  # two features each
    assert apart == {"multiplications": 5 * n_turns, "sums": 3 * n_turns}
