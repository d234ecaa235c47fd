"""Starts the node with a parameters file: `params:=FILE`, by default the installed example."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import LifecycleNode
from launch_ros.substitutions import FindPackageShare

PACKAGE = "peg_on_hole_ros"


def generate_launch_description():
    """Describe the one node."""
    default = PathJoinSubstitution([FindPackageShare(PACKAGE), "config", "peg_on_hole.yaml"])
    return LaunchDescription(
        [
            DeclareLaunchArgument("params", default_value=default),
            LifecycleNode(
                package=PACKAGE,
                executable="peg_on_hole",
                name="peg_on_hole",
                namespace="",
                parameters=[LaunchConfiguration("params")],
                output="screen",
            ),
        ]
    )
