"""What the model lacked, added to the statics that a network is trained on again."""

import numpy as np

from gravcomp.diagnosis.model import Model
from gravcomp.logs.measurement import Measurement
from gravcomp.training.training import TrainingSet, workspace_set

N_POSES = 2500


def augmented_set(lacking: Model, seed: int, n_poses: int = N_POSES) -> TrainingSet:
    """Poses of the workspace of the model's machine, with its statics and what lacking adds to them there."""
    machine = lacking.machine
    poses = workspace_set(n_poses, machine.robot, seed)
    data = Measurement(
        name="workspace",
        t_s=np.arange(n_poses, dtype=float),
        q=poses.q,
        v=None,
        force=poses.f,
        nominal=poses.f,
        unit=machine.effort_unit,
        position_units=machine.position_units,
        force_at=machine.robot.forces,
        robot=machine.robot,
    )
    return TrainingSet(poses.q, poses.f + lacking.predict(data))
