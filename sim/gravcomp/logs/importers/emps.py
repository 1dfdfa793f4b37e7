"""EMPS: one prismatic axis, DC motor and ball screw (Janot, Gautier, Brunot, 2019, nonlinearbenchmark.org).

Force = gtau vir. Position and force pass the same zero-phase Butterworth low-pass (4th order, run both ways); velocity
and acceleration are central differences of the filtered position; then the first and last 50 ms are cut
and every 5th sample is kept. The model is the
rigid one, f_model = M a with M = 95.1 kg.
"""

from pathlib import Path

import numpy as np
from scipy.io import loadmat
from scipy.io.matlab import MatReadError
from scipy.signal import butter, filtfilt

from gravcomp.errors import InputError

MASS_KG = 95.1
CUTOFF_HZ = 50.0
DECIMATION = 5
TRIM_S = 0.05  # at both ends, where the filter has nothing beyond


def emps_csv(path: Path | str) -> str:
    """The CSV of DATA_EMPS.mat (or DATA_EMPS_PULSES.mat). Raises InputError."""
    try:
        content = loadmat(path)
        t, position, control = (content[name].ravel().astype(float) for name in ("t", "qm", "vir"))
        gain = float(content["gtau"].item())
    except (OSError, ValueError, KeyError, NotImplementedError, MatReadError) as error:
        raise InputError(f"{path}: not the EMPS data ({error}); give DATA_EMPS.mat") from error
    step = float(np.median(np.diff(t)))
    low_pass = butter(4, CUTOFF_HZ * 2.0 * step)
    q, force = (filtfilt(*low_pass, signal) for signal in (position, gain * control))
    v = np.gradient(q, step)
    a = np.gradient(v, step)
    rows = np.column_stack([t, q, v, force, MASS_KG * a])
    edge = round(TRIM_S / step)
    rows = rows[edge:-edge:DECIMATION]
    head = (
        f"# EMPS, force = gtau vir; zero-phase Butterworth low-pass {CUTOFF_HZ:g} Hz, every {DECIMATION}th sample\n"
        f"# fm1_n = {MASS_KG} kg times the acceleration of the filtered position\n"
        "t_s,q1_m,v1_mps,f1_n,fm1_n\n"
    )
    return head + "".join(f"{t:.3f},{q:.8f},{v:.8f},{f:.6f},{m:.6f}\n" for t, q, v, f, m in rows)
