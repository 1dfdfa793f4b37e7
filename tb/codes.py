"""What tests and the lab's benches share, by the name that tests know it by."""

from gravcomp_lab.benches.codes import (
    ROOT,
    corners_and_random,
    fixed_compensation,
    fixed_network,
    hash_under_test,
    pack,
    pack_rows,
    unpack,
    weights_under_test,
)

__all__ = (
    "ROOT",
    "corners_and_random",
    "fixed_compensation",
    "fixed_network",
    "hash_under_test",
    "pack",
    "pack_rows",
    "unpack",
    "weights_under_test",
)
