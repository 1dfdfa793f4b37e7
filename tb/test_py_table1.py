"""The paper's Table 1: a short run of its command, and what the figures must show."""

import numpy as np
import pytest

from gravcomp.training.training import workspace_set
from gravcomp_lab.__main__ import main
from gravcomp_lab.paper.table1 import PAPER, TrainedRow, markdown, plain_start, table1
from machines import MACHINE


@pytest.fixture(scope="module")
def rows():
    data, unseen = workspace_set(300, MACHINE.robot, 1), workspace_set(300, MACHINE.robot, 2)
    return table1(data, unseen, MACHINE, n_starts=1, seed=1, backend="loky")


def test_table_has_a_row_per_size_of_the_paper_and_two_for_tanh(rows):
    assert [(r.n_hidden, r.trained_with, r.run_with) for r in rows] == [
        *((n, "gamma", "gamma") for n in PAPER),
        (20, "tanh", "tanh"),
        (20, "tanh", "gamma"),
    ]


def test_network_trained_with_tanh_fails_when_run_with_gamma(rows):
    as_tanh, as_gamma = rows[-2:]
    # Gamma differs from tanh by up to 0.043: with output weights of order 1 that is newtons, tens of times the error.
    assert np.sqrt(as_gamma.test_mse_n2) > 0.3
    assert as_gamma.test_mse_n2 > 100 * as_tanh.test_mse_n2


def test_a_start_stops_at_its_gradient_threshold():
    rng = np.random.default_rng(1)
    x = rng.uniform(-1, 1, (100, 3))
    fit = plain_start(x, x**2, 4, "gamma", 1e-3, 5)
    assert fit.reason == "gradient"
    assert fit.gradient < 1e-3


def test_markdown_puts_the_papers_figures_beside_ours():
    text = markdown(
        [TrainedRow(25, "gamma", "gamma", 0.001, 0.25, 0.16), TrainedRow(20, "tanh", "gamma", 0.001, 4.0, 9.0)]
    )
    assert "| 25 | gamma | gamma | 0.0500 | 0.0010 | 0.0268 | 0.25 | 0.16 | 0.400 |" in text
    assert "| 20 | tanh | gamma |  | 0.0010 |  | 4 | 9 | 3.000 |" in text


def test_command_prints_the_table_and_writes_it(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(
        "gravcomp_lab.commands.table1.table1", lambda *_, **__: [TrainedRow(15, "gamma", "gamma", 1.0, 2.0, 3.0)]
    )
    out = tmp_path / "table1.md"
    assert main(["table1", "--poses", "10", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    assert "| 15 | gamma | gamma | 0.0090 | 1.0000 | 0.0429 |" in printed
    assert printed.splitlines()[0] in out.read_text()


@pytest.mark.parametrize(
    ("arguments", "named"),
    [(["--starts", "0"], "0 starts"), (["--poses", "-5"], "-5 poses"), (["--seed", "-1"], "seed -1")],
)
def test_bad_arguments_end_in_one_line_and_status_2(arguments, named, tmp_path, capsys):
    assert main(["table1", "--out", str(tmp_path / "table1.md"), *arguments]) == 2
    assert named in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
