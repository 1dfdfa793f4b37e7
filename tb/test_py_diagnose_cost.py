"""What a diagnosis of many rows costs: what is dear is computed once."""

from collections import Counter
from dataclasses import replace

import numpy as np

from gravcomp.cli import main
from gravcomp.diagnosis.diagnosis import diagnose
from gravcomp.diagnosis.model import Model
from gravcomp.diagnosis.report import contributions, report
from gravcomp.robot.spheiro.robot import Spheiro
from measured_samples import motion

SEED = 3


class Counted(Spheiro):
    """The robot, counting the rows that it is asked about by each of its methods, in lengths of the log."""

    def __getattribute__(self, name):
        own = super().__getattribute__(name)
        if name not in ("payload_regressors", "passive_jacobian", "universal_jacobian", "universal_angles"):
            return own

        def counting(q):
            if len(q) > 100:  # the search looks at no fewer
                asked[name] += 1
            return own(q)

        return counting


asked = Counter()


def loaded_motion():
    """A motion with friction in the passive joints and a payload."""
    data = motion(800)
    robot = Counted(data.robot.parameters)
    rng = np.random.default_rng(SEED)
    force = data.nominal + data.robot.payload_regressors(data.q) @ [0.1, -0.2, 0.15] + 2.0 * np.sign(data.v)
    return replace(data, robot=robot, force=force + 0.1 * rng.standard_normal(data.shape))


def test_a_robot_is_asked_once_about_a_log():
    asked.clear()
    found = diagnose(loaded_motion(), Model())
    assert "payload" in [entry.name for entry in found.fit.effects]
    report.report(found)
    readings = 3  # of a log: as it is, and as other sensors would have written it, or with rows in doubt
    assert asked
    assert max(asked.values()) <= readings


def test_a_function_of_a_log_is_called_once():
    data, calls = motion(200), []

    def speed(own):
        calls.append(own)
        return np.abs(own.v)

    np.testing.assert_array_equal(data.once(speed), data.once(speed))
    assert len(calls) == 1
    assert replace(data, v=2 * data.v).once(speed).max() == 2 * data.once(speed).max()


def test_a_report_is_made_once(tmp_path, monkeypatch):
    calls = []
    original = contributions.contributions
    monkeypatch.setattr(report, "contributions", lambda d: calls.append(d) or original(d))
    t = np.arange(400) * 0.05
    q = np.sin(t) + 0.3 * np.sin(2.3 * t)
    v = np.gradient(q, t)
    rng = np.random.default_rng(SEED)
    rows = np.c_[t, q, v, 8 * np.cos(q) + 1.5 * np.sign(v) + 0.05 * rng.standard_normal(400), 8 * np.cos(q)]
    log = tmp_path / "log.csv"
    np.savetxt(log, rows, delimiter=",", header="t_s,q1_rad,v1_radps,f1_nm,fm1_nm", comments="")
    assert main(["diagnose", str(log), "--out", str(tmp_path / "report")]) == 0
    assert len(calls) == 1
