"""Results of gc_system against the bit-true model."""

import numpy as np

from codes import fixed_compensation, fixed_network
from gravcomp.core.image import Image
from gravcomp.twin import network as bittrue
from gravcomp.twin.compensator import compensator


def assert_bit_true(result: dict[str, np.ndarray], constants: Image | None = None) -> None:
    """AssertionError when the forces and currents are not those of the result's own position and speed.

    constants: those in use, if not the ROM's.
    """
    network = constants.network if constants else fixed_network()
    compensation = constants.compensation if constants else fixed_compensation()
    network_mn = bittrue.core(result["position"], network).force_mn
    force_mn, _ = compensator(network_mn, result["position"], result["speed_period"], compensation)
    np.testing.assert_array_equal(result["force_mn"], force_mn)
    np.testing.assert_array_equal(result["current_ua"], bittrue.current_scaler(force_mn, network))
