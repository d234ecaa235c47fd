"""
The node under the lifecycle manager of Nav2, which configures and activates it, and ends it.

    ros2 launch examples/managed.launch.py

Without Nav2 start the node by `autostart:=false`, and `ros2 lifecycle set /peg_on_hole configure`
and `activate` do the same.
"""

from launch import LaunchDescription
from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

MANAGER = {
    "autostart": True,
    "node_names": ["peg_on_hole"],
    # The node has no bond: its manager would take it down. /diagnostics tells whether it lives.
    "bond_timeout": 0.0,
    # The first start compiles, which takes minutes; older releases wait for ever.
    "service_timeout": 600.0,
}


def generate_launch_description():
    """Describe the node, which waits, and who manages it."""
    file = [FindPackageShare("peg_on_hole_ros"), "launch", "peg_on_hole.launch.py"]
    return LaunchDescription(
        [
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(PathJoinSubstitution(file)),
                launch_arguments={"autostart": "false"}.items(),
            ),
            Node(
                package="nav2_lifecycle_manager",
                executable="lifecycle_manager",
                name="lifecycle_manager_peg_on_hole",
                parameters=[MANAGER],
                output="screen",
            ),
        ]
    )
