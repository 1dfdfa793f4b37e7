"""gc_core with other networks: sizes come from the ROM package alone."""

from pathlib import Path

import pytest

from gravcomp.network.inputs import POSITION, SIN_COS
from gravcomp.robot.machine import LEAN, PAPER
from support.core import check_core, drawn_machine


def check_machine(inputs: tuple[str, ...], n_hidden: int, lanes: int, folder: Path, **options) -> None:
    """gc_core of a random network equals its model, at its interval and latency."""
    form = options.pop("form", PAPER)
    weights, generated = drawn_machine(inputs, n_hidden, folder, form)
    label = f"{form}-{''.join(kind[0] for kind in inputs)}-{n_hidden}"
    check_core(lanes, environment={"WEIGHTS": str(weights)}, generated=generated, label=label, **options)


@pytest.mark.parametrize(
    ("n_axes", "n_hidden", "lanes"), [(3, 7, 7), (2, 8, 1), (2, 2, 1), (1, 4, 1), (1, 4, 4), (4, 6, 2)]
)
def test_core_takes_its_sizes_from_the_rom(n_axes, n_hidden, lanes, tmp_path):
    check_machine((POSITION,) * n_axes, n_hidden, lanes, tmp_path)


@pytest.mark.parametrize(
    ("n_axes", "n_hidden", "lanes", "loadable"),
    [(1, 4, 1, "false"), (1, 4, 4, "true"), (2, 7, 2, "true"), (4, 6, 1, "false")],
)
def test_lean_core_takes_its_sizes_from_the_rom(n_axes, n_hidden, lanes, loadable, tmp_path):
    """Padded or not, with scales that differ from axis to axis."""
    check_machine((POSITION,) * n_axes, n_hidden, lanes, tmp_path, form=LEAN, generics={"loadable_g": loadable})


@pytest.mark.parametrize(("n_hidden", "lanes"), [(7, 2), (7, 4), (5, 8)])
@pytest.mark.parametrize("loadable", ["false", "true"])
def test_neurons_of_zero_weight_pad_what_lanes_do_not_divide(n_hidden, lanes, loadable, tmp_path):
    check_machine((POSITION,) * 2, n_hidden, lanes, tmp_path, generics={"loadable_g": loadable})


@pytest.mark.parametrize(
    ("inputs", "n_hidden", "lanes"),
    [
        ((SIN_COS,), 3, 1),
        ((SIN_COS, POSITION), 4, 1),  # each shares what it can
        ((POSITION, SIN_COS, POSITION, SIN_COS), 4, 2),  # two steps: the turns share, the positions do not
        ((SIN_COS, SIN_COS, POSITION), 4, 4),  # nothing is shared
    ],
)
def test_core_sees_sine_and_cosine_of_axes_that_turn(inputs, n_hidden, lanes, tmp_path):
    check_machine(inputs, n_hidden, lanes, tmp_path)
