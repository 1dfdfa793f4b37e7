"""gc_core with other networks: sizes come from the ROM package alone."""

import numpy as np
import pytest

from arm import arm_toml
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.network.weights import Network
from machines import machine_folder
from test_rtl_core import check_core


def random_network(n_axes: int, n_hidden: int) -> Network:
    rng = np.random.default_rng(n_axes * 100 + n_hidden)
    return Network(
        hidden_weights=rng.uniform(-3, 3, (n_hidden, n_axes)),
        hidden_bias=rng.uniform(-1, 1, n_hidden),
        output_weights=rng.uniform(-1, 1, (n_axes, n_hidden)),
        output_bias=rng.uniform(-0.2, 0.2, n_axes),
        q_offset=rng.uniform(-0.05, 0.05, n_axes),
        q_scale=rng.uniform(5, 8, n_axes),
        f_offset=rng.uniform(-50, 50, n_axes),
        f_scale=rng.uniform(40, 70, n_axes),
        position_units=("rad",) * n_axes,
    )


@pytest.mark.parametrize(
    ("n_axes", "n_hidden", "lanes"), [(3, 7, 7), (2, 8, 1), (2, 2, 1), (1, 4, 1), (1, 4, 4), (4, 6, 2)]
)
def test_core_takes_its_sizes_from_the_rom(n_axes, n_hidden, lanes, tmp_path):
    folder, generated = tmp_path / "weights", tmp_path / "generated"
    machine_folder(folder, random_network(n_axes, n_hidden), arm_toml(n_axes))
    write_rom(folder, generated)
    check_core(lanes, environment={"WEIGHTS": str(folder)}, generated=generated, label=f"{n_axes}-{n_hidden}")
