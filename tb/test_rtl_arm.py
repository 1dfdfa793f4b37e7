"""A two-axis arm from its statics to the RTL: trained, quantised, its ROM, the bit-true model, gc_core under GHDL.

In Nm and rad, checked against what a hand computes of a lever: nothing between robot.toml and the pins may know metres,
newtons or three axes.
"""

import numpy as np
import pytest

from arm import G_MPS2, arm_toml
from gravcomp.core.compensation import no_compensation
from gravcomp.core.folder import MachineFolder, load_folder, save_folder
from gravcomp.core.formats import quantise
from gravcomp.core.provenance import write_provenance
from gravcomp.core.vhdl.network_package import write_rom
from gravcomp.robot.machine import parse_machine
from gravcomp.training.training import Effort, train, workspace_set
from gravcomp.twin import network as bittrue
from runner import BUILD
from support.core import check_core

COUNTS_PER_TURN, AMPERE_PER_NM = 100_000, np.array([1 / 40, 1 / 20])
MASSES_KG, LENGTHS_M = np.array([3.0, 2.1]), np.array([0.4, 0.28])  # of arm_toml(2)
N_HIDDEN, LANES = 8, 4


@pytest.fixture(scope="module")
def trained():
    """The machine folder of the arm, its network trained, its packages in generated/."""
    folder = BUILD / "arm" / "weights"
    machine = parse_machine(arm_toml(2), "an arm")
    data = workspace_set(300, machine.robot, 5)
    effort = Effort(draws=5, tied_hops=3, hops=3, search_poses=150)
    network, _ = train(data, machine, n_hidden=N_HIDDEN, n_starts=1, seed=5, backend="threading", effort=effort)
    save_folder(folder, MachineFolder(machine, network, no_compensation(2)))
    write_provenance(folder, command="a test", data={}, metrics={}, machine=machine)
    write_rom(folder, folder.parent / "generated")
    return folder


def by_hand_nm(q_rad: np.ndarray) -> np.ndarray:
    """Torques (..., 2) of both joints: weights times their horizontal levers."""
    (l1, l2), (w1, w2) = LENGTHS_M, G_MPS2 * MASSES_KG
    first, second = np.cos(q_rad[..., 0]), np.cos(q_rad[..., 0] + q_rad[..., 1])
    outer = w2 * l2 / 2 * second
    return np.stack([(w1 / 2 + w2) * l1 * first + outer, outer], axis=-1)


def test_arm_holds_its_links_in_nm_at_counts_of_a_turn(trained):
    """In the pins' units: encoder counts in, mNm and uA out, within what so small a network leaves."""
    content = load_folder(trained)
    fixed = quantise(content.network, content.machine.drive, trained)
    counts = np.random.default_rng(3).integers(fixed.count_low, fixed.count_high, (2000, 2), endpoint=True)
    q_rad = counts * 2 * np.pi / COUNTS_PER_TURN
    torque_nm = by_hand_nm(q_rad)
    got_mnm = bittrue.core(counts, fixed).force_mn
    of_network_nm = np.abs(content.network.forces(q_rad) - torque_nm).max()
    print(f"MEASURED network {of_network_nm:.3f} Nm at most of {np.abs(torque_nm).max():.1f} Nm")
    assert of_network_nm < 0.01 * np.abs(torque_nm).max()
    np.testing.assert_allclose(got_mnm / 1e3, torque_nm, atol=of_network_nm + 5e-3)
    got_ua = bittrue.current_scaler(got_mnm, fixed)
    np.testing.assert_allclose(got_ua, 1e3 * got_mnm * AMPERE_PER_NM, rtol=1e-4, atol=1)
    assert content.machine.effort_unit == "Nm"
    assert content.network.position_units == ("rad", "rad")


def test_arm_in_the_rtl_equals_its_model(trained):
    check_core(
        LANES,
        environment={"WEIGHTS": str(trained)},
        generated=trained.parent / "generated",
        tests=r"\.(back_to_back|random_gaps)$",
        label="arm",
    )
