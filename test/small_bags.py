"""Small real bags for tests."""

from peg_on_hole_ros.bags.writer import BagWriter

WRENCH = "geometry_msgs/msg/WrenchStamped"
JOINTS = "sensor_msgs/msg/JointState"
MS = 1_000_000


def header(t_ns, frame="sensor"):
    return {"stamp": {"sec": t_ns // 10**9, "nanosec": t_ns % 10**9}, "frame_id": frame}


def wrench(t_ns, force=(0.0, 0.0, -10.0), torque=(0.0, 0.0, 0.0)):
    return {
        "header": header(t_ns),
        "wrench": {"force": dict(zip("xyz", force)), "torque": dict(zip("xyz", torque))},
    }


def joints(t_ns, position=(0.3, 0.0, 0.0)):
    return {
        "header": header(t_ns, ""),
        "name": ["gamma", "psi", "phi"],
        "position": list(position),
    }


def write_bag(
    path,
    count=200,
    wrench_topic="/wrench",
    joint_topic="/joint_states",
    start=10**9,
    chunk_bytes=1 << 20,
):
    """Write `count` wrenches at 1 kHz and half as many joint states."""
    with BagWriter(path, chunk_bytes=chunk_bytes) as bag:
        for i in range(count):
            t_ns = start + i * MS
            if wrench_topic:
                bag.write(wrench_topic, WRENCH, wrench(t_ns), t_ns)
            if joint_topic and i % 2 == 0:
                bag.write(joint_topic, JOINTS, joints(t_ns), t_ns)
    return path
