"""
Starts the node; `ros2 launch peg_on_hole_ros peg_on_hole.launch.py --show-args` lists arguments.

The node tells which parts of a parameters file are for it: of another name, write '/**:' there.
"""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.substitutions import FindPackageShare

PACKAGE = "peg_on_hole_ros"
# Topics that the node reads, each an argument of its own: where it is to be found.
INPUTS = ("wrench", "joint_states", "robot_description")


def generate_launch_description():
    """Describe the one node and its arguments."""
    default = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "peg_on_hole.yaml"])
    arguments = {
        "params": (default, "parameters file"),
        "name": ("peg_on_hole", "name of the node"),
        "namespace": ("", "namespace of the node"),
        "use_sim_time": ("false", "whether /clock is the node's clock"),
        **{topic: (f"/{topic}", f"topic that is read as {topic}") for topic in INPUTS},
    }
    given = {name: LaunchConfiguration(name) for name in arguments}
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=text)
                for name, (default, text) in arguments.items()
            ),
            LifecycleNode(
                package=PACKAGE,
                executable="peg_on_hole",
                name=given["name"],
                namespace=given["namespace"],
                parameters=[given["params"], {"use_sim_time": given["use_sim_time"]}],
                remappings=[(f"/{topic}", given[topic]) for topic in INPUTS],
                output="screen",
            ),
        ]
    )
