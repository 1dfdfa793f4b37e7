"""Files of MATLAB, ROS 2, LabVIEW, ASAM and Parquet, written by their own libraries, give the same diagnosis input."""

import re
import sys

import numpy as np
import pytest
from scipy.io import savemat

from gravcomp.cli import main
from gravcomp.logs.csv_reader import read_measurement

N = 60
T = 0.05 * np.arange(N)
Q = np.column_stack([np.sin(T), 0.2 * np.cos(T)])
V = np.column_stack([np.cos(T), -0.2 * np.sin(T)])
EFFORT = np.column_stack([8.0 * np.cos(Q[:, 0]) + 0.5, 30.0 + 0.0 * T])
MODEL = np.column_stack([8.0 * np.cos(Q[:, 0]), 29.0 + 0.0 * T])
NAMES = ["t_s", "q1_rad", "q2_m", "v1_radps", "v2_mps", "f1_nm", "f2_n", "fm1_nm", "fm2_n"]
COLUMNS = dict(zip(NAMES, np.column_stack([T, Q, V, EFFORT, MODEL]).T, strict=True))


def imported(tmp_path, kind, path, *options):
    out = tmp_path / "log.csv"
    assert main(["import", kind, str(path), "--out", str(out), *options]) == 0
    return read_measurement(out)


def refused(tmp_path, capsys, kind, path, *options) -> str:
    assert main(["import", kind, str(path), "--out", str(tmp_path / "log.csv"), *options]) == 2
    message = capsys.readouterr().err.strip()
    assert "\n" not in message
    assert not (tmp_path / "log.csv").exists()
    return message


def assert_same(data, atol=1e-9, rows=slice(None)):
    for given, wanted in ((data.t_s - data.t_s[0], T - T[rows][0]), (data.q, Q), (data.v, V), (data.force, EFFORT),
                          (data.nominal, MODEL)):  # fmt: skip
        np.testing.assert_allclose(given, wanted[rows], atol=atol)
    assert (data.position_units, data.effort_units) == (("rad", "m"), ("Nm", "N"))


def in_degrees() -> dict[str, np.ndarray]:
    """The same log as another tool names and measures it."""
    return {"time": T, "Axis1 Pos": np.rad2deg(Q[:, 0]), "Axis2 Pos": 1e3 * Q[:, 1], "Axis1 Vel": np.rad2deg(V[:, 0]),
            "Axis2 Vel": 1e3 * V[:, 1], "Axis1 Torque": EFFORT[:, 0], "Axis2 Force": EFFORT[:, 1],
            "Model1": MODEL[:, 0], "Model2": MODEL[:, 1]}  # fmt: skip


OF_THEM = ["t_s=time", "q1_deg=Axis1 Pos", "q2_mm=Axis2 Pos", "v1_degps=Axis1 Vel", "v2_mmps=Axis2 Vel",
           "f1_nm=Axis1 Torque", "f2_n=Axis2 Force", "fm1_nm=Model1", "fm2_n=Model2"]  # fmt: skip
UNITS = dict(zip(in_degrees(), ["s", "deg", "mm", "°/s", "mm/s", "N·m", "N", "Nm", "N"], strict=True))
BY_THE_FILE = [re.sub("_[a-z]+=", "=", pair) for pair in OF_THEM if not pair.startswith("t_")]


def test_mat_of_vectors(tmp_path):
    savemat(tmp_path / "log.mat", {"Run": {name.replace(" ", ""): x for name, x in in_degrees().items()}})
    options = [re.sub("=(.*)", lambda m: f"=Run.{m[1].replace(' ', '')}", pair) for pair in OF_THEM]
    assert_same(imported(tmp_path, "mat", tmp_path / "log.mat", "--columns", *options))


@pytest.mark.parametrize("is_upright", [True, False])
def test_mat_of_arrays_by_joint(tmp_path, is_upright):
    arrays = {"t": T, "q": Q[:, :1], "dq": V[:, :1], "tau": EFFORT[:, :1], "g": MODEL[:, :1]}
    savemat(tmp_path / "log.mat", {k: x if is_upright or x.ndim == 1 else x.T for k, x in arrays.items()})
    options = ["t_s=t", "q_rad=q", "v_radps=dq", "f_nm=tau", "fm_nm=g"]
    data = imported(tmp_path, "mat", tmp_path / "log.mat", "--columns", *options)
    np.testing.assert_allclose(
        np.hstack([data.q, data.v, data.force]), np.column_stack([Q[:, 0], V[:, 0], EFFORT[:, 0]])
    )


@pytest.mark.parametrize("order", ["joint,pose,repeat", "pose,repeat,joint"])
def test_mat_by_joint_pose_and_repeat(tmp_path, order):
    """Two joints, 20 poses, 3 repeats: all repeats of a pose follow one another, and a model by pose holds for each."""
    rng = np.random.default_rng(1)
    q, effort, sign = (
        rng.uniform(-1, 1, (2, 20, 1)) + np.zeros(3),
        rng.uniform(1, 2, (2, 20, 3)),
        np.array([1.0, -1, 1]),
    )
    axes = [("joint", "pose", "repeat").index(name) for name in order.split(",")]
    own = {"q": q.transpose(axes), "tau": effort.transpose(axes), "g": 2.0 * q[:, :, 0], "approach": 0.1 * sign}
    savemat(tmp_path / "log.mat", own)
    columns = ["--columns", "q_rad=q", "f_nm=tau", "fm_nm=g", "v_radps=approach"]
    data = imported(tmp_path, "mat", tmp_path / "log.mat", "--dims", order, *columns)
    assert data.shape == (60, 2)
    np.testing.assert_allclose(data.q[:3], np.tile(q[:, 0, 0], (3, 1)))
    np.testing.assert_allclose(data.force, effort.reshape(2, 60).T)
    np.testing.assert_allclose(data.nominal, 2.0 * data.q)
    np.testing.assert_allclose(data.v, np.tile(own["approach"], 20)[:, None] + np.zeros(2))
    np.testing.assert_allclose(data.t_s, np.arange(60))


def test_mat_of_version_7_3(tmp_path):
    h5py = pytest.importorskip("h5py", reason="extra mat is not installed")
    with h5py.File(tmp_path / "log.mat", "w", userblock_size=512) as file:
        for name, x in COLUMNS.items():
            file[name] = x[None, :]  # MATLAB's columns lie in rows there
    with open(tmp_path / "log.mat", "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")
    assert_same(imported(tmp_path, "mat", tmp_path / "log.mat"))


def test_parquet_with_and_without_units(tmp_path):
    arrow = pytest.importorskip("pyarrow", reason="extra parquet is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    parquet.write_table(arrow.table(COLUMNS), tmp_path / "a.parquet")
    assert_same(imported(tmp_path, "parquet", tmp_path / "a.parquet"))
    fields = [arrow.field(name, arrow.float64(), metadata={"unit": UNITS[name]}) for name in in_degrees()]
    parquet.write_table(arrow.table(in_degrees(), schema=arrow.schema(fields)), tmp_path / "b.parquet")
    assert_same(imported(tmp_path, "parquet", tmp_path / "b.parquet", "--columns", *BY_THE_FILE))


def test_parquet_leaves_gaps_and_dates_to_the_reader(tmp_path):
    arrow = pytest.importorskip("pyarrow", reason="extra parquet is not installed")
    parquet = pytest.importorskip("pyarrow.parquet")
    stamps = 1_700_000_000_000_000_000 + (1e9 * T).astype(np.int64)
    columns = {**COLUMNS, "t_ns": arrow.array(stamps, arrow.timestamp("ns")), "q2_m": [None, *Q[1:, 1]]}
    del columns["t_s"]
    parquet.write_table(arrow.table(columns), tmp_path / "a.parquet")
    data = imported(tmp_path, "parquet", tmp_path / "a.parquet")
    assert data.n_dropped == 1
    assert_same(data, atol=1e-6, rows=slice(1, None))


@pytest.mark.parametrize("has_clock", [True, False])
def test_tdms(tmp_path, has_clock):
    nptdms = pytest.importorskip("nptdms", reason="extra tdms is not installed")
    clock = {"wf_increment": 0.05, "wf_start_offset": 0.0, "wf_start_time": np.datetime64("2026-01-01T00:00:00")}
    with nptdms.TdmsWriter(tmp_path / "log.tdms") as file:
        file.write_segment([
            nptdms.ChannelObject("run", name, x, {"unit_string": UNITS[name], **(clock if has_clock else {})})
            for name, x in in_degrees().items() if name != "time" or not has_clock
        ])  # fmt: skip
    time = [] if has_clock else ["t=time"]
    assert_same(imported(tmp_path, "tdms", tmp_path / "log.tdms", "--columns", *time, *BY_THE_FILE))


def test_mdf_brings_signals_of_two_rates_on_the_clock_of_the_first_position(tmp_path):
    asammdf = pytest.importorskip("asammdf", reason="extra mdf is not installed")
    with asammdf.MDF(version="4.10") as file:
        for name, x in in_degrees().items():
            if name == "time":
                continue
            is_slow = name == "Axis2 Force"  # constant: a straight line between its samples is exact
            rows = slice(None, None, 4 if is_slow else 1)
            file.append(asammdf.Signal(x[rows], T[rows], unit=UNITS[name], name=name))
        file.save(tmp_path / "log.mf4")
    data = imported(tmp_path, "mdf", tmp_path / "log.mf4", "--columns", *BY_THE_FILE)
    assert_same(data, rows=slice(0, 57))


PRISMATIC = ["q2_m=slide.position", "v2_mps=slide.velocity", "f2_n=slide.effort", "fm2_n=/model:slide.effort",
             "fm1_nm=/model:arm.effort"]  # fmt: skip


def joint_states(k: int) -> list[tuple[str, int, dict]]:
    """Topic, stamp in ns and fields of what row k says: the robot's state and, on another topic, its model."""
    stamp, names = round(1e9 * T[k]) + 1_700_000_000_000_000_000, ["arm", "slide"]
    return [("/joint_states", stamp, {"name": names, "position": Q[k], "velocity": V[k], "effort": EFFORT[k]}),
            ("/model", stamp, {"name": names, "position": [], "velocity": [], "effort": MODEL[k]})]  # fmt: skip


@pytest.mark.parametrize("storage", ["SQLITE3", "MCAP"])
def test_rosbag2(tmp_path, storage):
    rosbag2 = pytest.importorskip("rosbags.rosbag2", reason="extra rosbag is not installed")
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    names = ("sensor_msgs/msg/JointState", "std_msgs/msg/Header", "builtin_interfaces/msg/Time")
    kind, header, time = (store.types[name] for name in names)
    with rosbag2.Writer(tmp_path / "bag", version=9, storage_plugin=rosbag2.StoragePlugin[storage]) as bag:
        own = {
            topic: bag.add_connection(topic, kind.__msgtype__, typestore=store) for topic in ("/joint_states", "/model")
        }
        for k in range(N):
            for topic, ns, fields in joint_states(k):
                fields |= {key: np.asarray(fields[key], float) for key in ("position", "velocity", "effort")}
                message = kind(header=header(stamp=time(sec=ns // 10**9, nanosec=ns % 10**9), frame_id=""), **fields)
                bag.write(own[topic], ns + 10**6, store.serialize_cdr(message, kind.__msgtype__))
    assert_same(imported(tmp_path, "rosbag", tmp_path / "bag", "--columns", *PRISMATIC))


JOINT_STATE = """std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


def test_mcap(tmp_path):
    writer = pytest.importorskip("mcap_ros2.writer", reason="extra mcap is not installed")
    with open(tmp_path / "log.mcap", "wb") as file:
        out = writer.Writer(file)
        schema = out.register_msgdef("sensor_msgs/msg/JointState", JOINT_STATE)
        for k in range(N):
            for topic, ns, fields in joint_states(k):
                fields |= {key: list(fields[key]) for key in ("position", "velocity", "effort")}
                header = {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": ""}
                out.write_message(topic, schema, {"header": header, **fields}, log_time=ns + 10**6, publish_time=ns)
        out.finish()
    assert_same(imported(tmp_path, "mcap", tmp_path / "log.mcap", "--columns", *PRISMATIC))


@pytest.mark.parametrize("kind", ["mat", "mcap", "mdf", "parquet", "rosbag", "tdms"])
def test_file_of_another_kind_is_one_line(tmp_path, capsys, kind):
    (tmp_path / "other.bin").write_bytes(b"this is none of them" * 40)
    message = refused(tmp_path, capsys, kind, tmp_path / "other.bin")
    if "is not installed" in message:
        pytest.skip(message)
    assert "other.bin: no " in message
    assert "; give " in message


@pytest.mark.parametrize(
    ("kind", "module", "package"),
    [
        ("mcap", "mcap", "mcap-ros2-support"),
        ("mdf", "asammdf", "asammdf"),
        ("parquet", "pyarrow", "pyarrow"),
        ("rosbag", "rosbags", "rosbags"),
        ("tdms", "nptdms", "nptdms"),
    ],
)
def test_missing_extra_is_one_line_that_says_what_to_install(tmp_path, capsys, monkeypatch, kind, module, package):
    for name in [module, *(name for name in sys.modules if name.startswith(f"{module}."))]:
        monkeypatch.setitem(sys.modules, name, None)
    message = refused(tmp_path, capsys, kind, tmp_path / "log")
    assert f"{package} is not installed" in message
    assert f"-m pip install {package}`" in message


BAD = {
    "no such signal": (["q1_rad=Pos9"], "no signal 'Pos9'; give one of "),
    "no unit": (["q1=position"], "signal position has no unit; say it, as in q1_deg=position"),
    "no position": (["f1_nm=tau"], "no position among its signals; say which is which with --columns"),
    "no column": (["x1_rad=position"], "--columns x1_rad=position: not COLUMN=SIGNAL"),
    "array as one axis": (["q1_rad=both"], "signal both has 2 columns; name them all, as in q_rad=both"),
    "lengths": (["q1_rad=position", "f1_nm=short"], "columns differ in length and have no clock (t_s 60, q1_rad 60, "),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_wrong_choice_is_one_line(tmp_path, capsys, case):
    pairs, told = BAD[case]
    savemat(tmp_path / "log.mat", {"position": T, "tau": T, "both": Q, "short": T[:50]})
    assert told in refused(tmp_path, capsys, "mat", tmp_path / "log.mat", "--columns", *pairs)


def test_dims_are_those_of_mat(tmp_path, capsys):
    savemat(tmp_path / "log.mat", {"q": np.ones((2, 3, 4))})
    assert "--dims pose: give joint,pose,repeat" in refused(
        tmp_path, capsys, "mat", tmp_path / "log.mat", "--dims", "pose"
    )
    assert "--dims: only a mat" in refused(
        tmp_path, capsys, "tdms", tmp_path / "log.mat", "--dims", "pose,joint,repeat"
    )
