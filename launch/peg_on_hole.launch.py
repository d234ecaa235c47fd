"""
Starts the node; `ros2 launch peg_on_hole_ros peg_on_hole.launch.py --show-args` lists arguments.

The node tells which parts of a parameters file are for it: of another name, write '/**:' there.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.substitutions import FindPackageShare

PACKAGE = "peg_on_hole_ros"
# Parameters that an argument may set, with what they do.
OVERRIDES = {
    "autostart": "whether the node configures and activates itself; false: another program does",
    "use_sim_time": "whether /clock is the node's clock",
}
# Topics that the node reads, each an argument of its own: where it is to be found.
INPUTS = ("wrench", "joint_states", "robot_description")


def generate_launch_description():
    """Describe the one node and its arguments."""
    default = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "peg_on_hole.yaml"])
    arguments = {
        "params": (default, "parameters file"),
        "name": ("peg_on_hole", "name of the node"),
        "namespace": ("", "namespace of the node"),
        **{name: ("", f"{text}; empty: as in params") for name, text in OVERRIDES.items()},
        **{topic: (f"/{topic}", f"topic that is read as {topic}") for topic in INPUTS},
    }
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in arguments.items()
            ),
            OpaqueFunction(function=_node),
        ]
    )


def _node(context):
    given = {name: LaunchConfiguration(name) for name in OVERRIDES}
    stated = {name: value for name, value in given.items() if value.perform(context)}
    return [
        LifecycleNode(
            package=PACKAGE,
            executable="peg_on_hole",
            name=LaunchConfiguration("name"),
            namespace=LaunchConfiguration("namespace"),
            parameters=[LaunchConfiguration("params"), *([stated] if stated else [])],
            remappings=[(f"/{topic}", LaunchConfiguration(topic)) for topic in INPUTS],
            output="screen",
        )
    ]
