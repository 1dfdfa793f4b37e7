"""The operations of one inference, counted in the running VHDL: 166 multiplications and 43 sums at hidden size 20."""

import pytest

from codes import weights_under_test
from gravcomp.network.weights import load_network
from gravcomp_lab.benches.budget import budget_run
from gravcomp_lab.paper.operations import count_network_operations
from runner import BUILD, ROOT, RTL


@pytest.mark.parametrize("lanes", [1, 4])
def test_core_runs_the_budgeted_operations(lanes):
    total = budget_run(lanes, RTL, BUILD, weights_under_test())
    counted = count_network_operations(load_network(ROOT / "weights" / "spheiro"))
    assert total == {"multiplications": counted.multiplications, "sums": counted.sums}
    assert total == {"multiplications": 166, "sums": 43}
