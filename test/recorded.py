"""Bags as other recorders write them, of messages that rosbags encodes."""

from contextlib import contextmanager
from typing import NamedTuple

import numpy as np
import zstandard
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from small_bags import JOINTS, MS, WRENCH

STORE = get_typestore(Stores.ROS2_JAZZY)
INPUTS = {"/wrench": WRENCH, "/joint_states": JOINTS}
PACK = zstandard.ZstdCompressor().compress


class Row(NamedTuple):
    topic: str
    log_ns: int
    data: bytes


def header(t_ns, frame="sensor"):
    stamp = STORE.types["builtin_interfaces/msg/Time"](sec=t_ns // 10**9, nanosec=t_ns % 10**9)
    return STORE.types["std_msgs/msg/Header"](stamp=stamp, frame_id=frame)


def wrench(t_ns, force=(0.0, 0.0, -10.0), torque=(0.0, 0.0, 0.0), frame="sensor"):
    vectors = (STORE.types["geometry_msgs/msg/Vector3"](*map(float, v)) for v in (force, torque))
    both = STORE.types["geometry_msgs/msg/Wrench"](*vectors)
    message = STORE.types[WRENCH](header=header(t_ns, frame), wrench=both)
    return bytes(STORE.serialize_cdr(message, WRENCH))


def joints(
    t_ns,
    position=(0.3, 0.0, 0.0),
    names=("gamma", "psi", "phi"),
    velocity=(),
    frame="",
    effort=(),
):
    message = STORE.types[JOINTS](
        header=header(t_ns, frame),
        name=list(names),
        position=np.array(position, float),
        velocity=np.array(velocity, float),
        effort=np.array(effort, float),
    )
    return bytes(STORE.serialize_cdr(message, JOINTS))


def motion(count=400, start=10**9, period=MS):
    """Return wrenches, and every second time a joint state before them, with log time = stamp."""
    rows = []
    for i in range(count):
        t_ns = start + i * period
        if i % 2 == 0:
            rows.append(Row("/joint_states", t_ns, joints(t_ns, (0.3 - 1e-5 * i, 0.0, 1e-4 * i))))
        rows.append(Row("/wrench", t_ns, wrench(t_ns, (0.1, -0.2, -10.0 - 1e-3 * i))))
    return rows


def definition(kind):
    return STORE.generate_msgdef(kind, ros_version=2)[0]


@contextmanager
def writer(path, text=definition, encoding=("cdr", "ros2msg"), metadata=None, **options):
    """Yield what writes a row; `text` None: channels without a schema."""
    channels = {}
    with open(path, "wb") as stream:
        mcap = Writer(stream, **options)
        mcap.start(profile="ros2")
        for name, values in (metadata or {}).items():
            mcap.add_metadata(name, values)

        def write(row, kind=None):
            if row.topic not in channels:
                kind, schema = kind or INPUTS[row.topic], 0
                if text is not None:
                    schema = mcap.register_schema(kind, encoding[1], text(kind).encode())
                channels[row.topic] = mcap.register_channel(row.topic, encoding[0], schema)
            mcap.add_message(channels[row.topic], row.log_ns, row.data, row.log_ns)

        yield write
        mcap.finish()


def write(path, rows, **options):
    with writer(path, **options) as add:
        for row in rows:
            add(row)
    return path


def described(*names, storage="mcap", version=9, more=""):
    return (
        f"rosbag2_bagfile_information:\n  version: {version}\n"
        f"  storage_identifier: {storage}\n  relative_file_paths: [{', '.join(names)}]\n{more}"
    )


def records(data):
    """Return begin, opcode and end of each record that is not in a chunk."""
    found, at = [], 8
    while at < len(data) - 8:
        end = at + 9 + int.from_bytes(data[at + 1 : at + 9], "little")
        found.append((at, data[at], end))
        at = end
    return found


UNPACKED = CompressionType.NONE
