"""A sweep of sizes: what each costs in the core, a machine folder of each, table and picture."""

import pytest

from gravcomp.cli import main
from gravcomp.core.cost import CoreCost
from gravcomp.network.weights import load_network
from gravcomp.training.sweep import Size, table
from machines import SHIPPED

# Lanes of the shipped core: interval and latency that its simulation measures, multipliers that synthesis counts.
MEASURED = {1: (20, 44, 9), 2: (10, 27, 20), 4: (5, 23, 34), 5: (4, 23, 41), 10: (2, 22, 76), 20: (1, 25, 146)}


@pytest.mark.parametrize("lanes", MEASURED)
def test_costs_of_the_shipped_core_are_those_measured(lanes):
    cost = CoreCost(20, 3, 3, lanes)
    assert (cost.interval, cost.latency, cost.multipliers) == MEASURED[lanes]
    assert (cost.multiplications, cost.sums) == (166, 43)


def test_table_has_a_row_of_each_size():
    sizes = [Size(n, 3, 3, 1.0 / n, 10.0 / n, 3.0 / n) for n in (8, 20)]
    rows = table(sizes, "N").splitlines()
    assert rows[2] == "| 8 | 0.125 | 1.25 | 0.375 | 70 | 19 | 9 | 8, 32 | 34 | 2, 20 |"
    assert len(rows) == 4


def test_command_trains_every_size_and_shows_them(tmp_path, capsys):
    arguments = ["--hidden", "4,6", "--poses", "120", "--starts", "1", "--search", "0.02", "--polish", "20"]
    arguments += ["--backend", "threading"]
    assert main(["train", "--robot", str(SHIPPED), "--out", str(tmp_path), *arguments]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"4", "6", "sweep.md", "sweep.png"}
    assert [load_network(tmp_path / size).n_hidden for size in ("4", "6")] == [4, 6]
    assert (tmp_path / "sweep.md").read_text() in capsys.readouterr().out
    assert (tmp_path / "sweep.png").read_bytes().startswith(b"\x89PNG")


def test_sizes_that_are_no_numbers_are_one_line(tmp_path, capsys):
    with pytest.raises(SystemExit) as ended:
        main(["train", "--robot", str(SHIPPED), "--out", str(tmp_path / "out"), "--hidden", "8,x"])
    assert ended.value.code == 2
    message = capsys.readouterr().err
    assert "'8,x': give whole numbers, such as 20 or 8,12,20" in message
    assert len(message.splitlines()) == 1


def test_network_that_is_trained_further_has_one_size(tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["train", "--from", str(SHIPPED), "--hidden", "4,6", "--out", str(out)]) == 2
    assert "--from keeps the neurons of its network" in capsys.readouterr().err
    assert not out.exists()
