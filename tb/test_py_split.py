"""Held-out samples: whole stretches of time or clusters of poses, every row on one side, the same for the same seed."""

from dataclasses import replace

import numpy as np
import pytest

from gravcomp.diagnosis.samples.split import TEST_SHARE, block_labels, folds, held_out
from gravcomp.errors import InputError
from measured_samples import holds, motion, sampled

DATA = {"motion": motion(1000), "few in motion": motion(60), "holds": holds(400, 1), "few holds": holds(40, 2)}
every_data = pytest.mark.parametrize("data", DATA.values(), ids=DATA)


def split(data, seed=0, rule="blocks"):
    return held_out(data, block_labels(data, seed), seed, rule)


@every_data
def test_block_is_on_one_side_and_both_sides_have_their_share(data):
    for seed in range(10):
        blocks = block_labels(data, seed)
        is_test = held_out(data, blocks, seed)
        assert is_test.shape == data.t_s.shape == blocks.shape
        assert all(len(set(is_test[blocks == block])) == 1 for block in set(blocks))
        assert TEST_SHARE <= is_test.mean() <= TEST_SHARE + 1.6 * np.bincount(blocks).max() / len(blocks)


@pytest.mark.parametrize("name", ["motion", "few in motion"])
def test_neighbours_in_time_part_only_at_the_ends_of_long_stretches(name):
    data = DATA[name]
    blocks = block_labels(data, 0)
    assert (np.diff(blocks) >= 0).all()
    lengths = np.bincount(blocks)
    assert lengths.max() - lengths.min() <= 1
    assert 8 <= len(lengths) <= 40
    parted = np.count_nonzero(np.diff(split(data).astype(int)))
    assert parted <= 2 * np.ceil(TEST_SHARE * len(lengths) + 1)


def test_scattered_holds_part_by_pose_and_not_by_time():
    data = DATA["holds"]
    blocks = block_labels(data, 0)
    within = np.mean([data.q[blocks == block].var(axis=0).sum() for block in set(blocks)])
    assert within < 0.2 * data.q.var(axis=0).sum()
    is_test = split(data)
    distance = np.linalg.norm(data.q[:, None] - data.q, axis=-1) + np.eye(len(data.q))
    parted = is_test[is_test] != is_test[distance.argmin(axis=1)][is_test]
    print(f"MEASURED nearest pose of a held-out hold is a training hold in {100 * parted.mean():.0f} %")
    assert parted.mean() < 0.5 * (1 - TEST_SHARE)  # by chance 75 %


def test_a_motion_in_a_corner_of_where_the_holds_are_is_divided():
    """A motion in a corner of where the holds are: as one cluster of poses it would be on one side, whole."""
    apart, near = holds(175, 3), motion(525)
    shrink = 0.05
    data = sampled(
        np.append(apart.t_s, apart.t_s[-1] + 2.0 + near.t_s),
        np.vstack([apart.q, shrink * near.q]),
        np.vstack([apart.v, shrink * near.v]),
    )
    is_motion = data.is_motion
    assert np.count_nonzero(is_motion[175:]) > 500
    assert not is_motion[:175].any()
    blocks = block_labels(data, 0)
    assert np.bincount(blocks).max() <= len(blocks) / 8
    for seed in range(10):
        is_test = split(data, seed)
        assert 0.0 < is_test[is_motion].mean() < 0.5


def test_folds_leave_blocks_whole_and_too_few_blocks_have_none():
    blocks = np.repeat(np.arange(4), [5, 3, 9, 2])
    parts = folds(blocks)
    assert sorted(np.concatenate([test for _, test in parts])) == list(range(19))
    assert all(not set(blocks[train]) & set(blocks[test]) for train, test in parts)
    assert folds(np.minimum(blocks, 2)) == []


@every_data
def test_same_seed_gives_the_same_samples_and_another_seed_others(data):
    np.testing.assert_array_equal(split(data, 3), split(data, 3))
    assert any((split(data, seed) != split(data, 0)).any() for seed in (1, 2, 3))


def test_last_quarter_and_reverse_are_what_they_say():
    data = DATA["motion"]
    assert np.flatnonzero(split(data, rule="last")).tolist() == list(range(750, 1000))
    np.testing.assert_array_equal(split(data, rule="reverse"), data.v[:, 0] < 0)


@pytest.mark.parametrize("v", [None, "forward", "backward"])
def test_reverse_without_both_directions_is_refused(v):
    data = DATA["motion"]
    speed = {None: None, "forward": np.abs(data.v), "backward": -np.abs(data.v)}[v]
    with pytest.raises(InputError, match=r"samples: reverse .* axis 1 doesn't move both ways"):
        split(replace(data, v=speed), rule="reverse")


def test_few_poses_held_again_and_again_leave_samples_on_both_sides():
    data = DATA["holds"]
    which = np.random.default_rng(1).choice(3, 400, p=[0.9, 0.05, 0.05])
    again = replace(data, q=data.q[:3][which])
    for seed in range(10):
        assert 0 < split(again, seed).sum() < 400
