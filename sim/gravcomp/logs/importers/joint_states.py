"""ROS 2 joint states, from a recording of rosbag2 or from a single MCAP file.

Axes are the joints in the order of the first message. Revolute is assumed: rad, rad/s, Nm; a prismatic joint is told by
``--columns q2_m=slide.position v2_mps=slide.velocity f2_n=slide.effort``.
"""

from collections.abc import Iterator
from pathlib import Path

import numpy as np

from gravcomp.errors import InputError, optional
from gravcomp.logs.importers.signals import Signal

_TYPE = "sensor_msgs/msg/JointState"
_FIELDS = {"position": ("q", "rad"), "velocity": ("v", "radps"), "effort": ("f", "nm")}


def rosbag_signals(path: Path) -> dict[str, Signal]:
    """Joint states of a rosbag2 folder, storage sqlite3 or mcap. Raises InputError."""
    highlevel, typesys = (optional(f"rosbags.{part}", "rosbags", "a rosbag") for part in ("highlevel", "typesys"))
    store = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)  # for recordings that hold no definitions
    try:
        with highlevel.AnyReader([path if path.is_dir() else path.parent], default_typestore=store) as reader:
            own = [connection for connection in reader.connections if connection.msgtype == _TYPE]
            messages = [(c.topic, t, reader.deserialize(raw, c.msgtype)) for c, t, raw in reader.messages(own)]
    except (highlevel.AnyReaderError, OSError, ValueError) as error:
        raise InputError(f"{path}: no recording of rosbag2 ({error}); give its folder") from error
    return _signals(path, iter(messages))


def mcap_signals(path: Path) -> dict[str, Signal]:
    """Joint states of an MCAP file of ROS 2. Raises InputError."""
    mcap, ros2 = (optional(part, "mcap-ros2-support", "an MCAP file") for part in ("mcap.reader", "mcap_ros2.decoder"))
    from mcap.exceptions import McapError

    try:
        with open(path, "rb") as file:
            reader = mcap.make_reader(file, decoder_factories=[ros2.DecoderFactory()])
            messages = [(channel.topic, raw.log_time, message)
                        for schema, channel, raw, message in reader.iter_decoded_messages()
                        if schema.name == _TYPE]  # fmt: skip
    except (McapError, OSError, ValueError) as error:
        raise InputError(f"{path}: no MCAP file of ROS 2 ({error}); give a .mcap with joint states") from error
    return _signals(path, iter(messages))


def _signals(path: Path, messages: Iterator) -> dict[str, Signal]:
    """Signals ``joint.position`` and so on of the first topic, those of others as ``/topic:joint.position``."""
    by_topic: dict[str, list] = {}
    for topic, log_ns, message in messages:
        by_topic.setdefault(topic, []).append((log_ns, message))
    if not by_topic:
        raise InputError(f"{path}: no message of type {_TYPE}; record the topic of the joint states")
    start_ns = min(_stamp_ns(*kept[0]) for kept in by_topic.values())
    out = {}
    for topic, kept in sorted(by_topic.items(), key=lambda item: -len(item[1])):
        prefix = f"{topic}:" if out else ""
        out |= {f"{prefix}{name}": signal for name, signal in _of_topic(kept, start_ns).items()}
    return out


def default_columns(signals: dict[str, Signal]) -> dict[str, str]:
    """Columns of the first topic's joints: q1_rad is the position of the first joint, and so on."""
    joints = list(dict.fromkeys(name.rpartition(".")[0] for name in signals if ":" not in name))
    wanted = {f"{stem}{k}_{unit}": f"{joint}.{field}" for k, joint in enumerate(joints, start=1)
              for field, (stem, unit) in _FIELDS.items()}  # fmt: skip
    return {target: name for target, name in wanted.items() if name in signals}


def _of_topic(kept: list, start_ns: int) -> dict[str, Signal]:
    names = list(kept[0][1].name)
    kept = [(ns, message) for ns, message in kept if list(message.name) == names]
    t_s = np.array([_stamp_ns(ns, message) - start_ns for ns, message in kept]) * 1e-9
    out = {}
    for field in _FIELDS:
        values = [np.asarray(getattr(message, field), float) for _, message in kept]
        if all(len(own) == len(names) for own in values):
            out |= {
                f"{name}.{field}": Signal(own, t_s=t_s) for name, own in zip(names, np.array(values).T, strict=True)
            }
    return out


def _stamp_ns(log_ns: int, message) -> int:
    """Time of the measurement; of the recording where the message has none."""
    stamp = message.header.stamp
    return stamp.sec * 10**9 + stamp.nanosec or log_ns
