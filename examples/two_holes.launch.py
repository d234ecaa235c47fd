"""
Two holes of one robot, a node for each, in one tree of frames.

    ros2 launch examples/two_holes.launch.py

two_holes.yaml has what both share, and a part for each node by its full name. The nodes read the
same /wrench and /joint_states; their topics are /left/peg_on_hole/... and /right/peg_on_hole/...
"""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import GroupAction, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import PathJoinSubstitution
from launch_ros.substitutions import FindPackageShare

HOLES = ("left", "right")
PARAMS = Path(__file__).with_name("two_holes.yaml")


def generate_launch_description():
    """Describe a node for each hole."""
    file = [FindPackageShare("peg_on_hole_ros"), "launch", "peg_on_hole.launch.py"]
    # In a group each: what is given to one would be the other's too.
    return LaunchDescription(
        [
            GroupAction(
                [
                    IncludeLaunchDescription(
                        PythonLaunchDescriptionSource(PathJoinSubstitution(file)),
                        launch_arguments={"namespace": hole, "params": str(PARAMS)}.items(),
                    )
                ]
            )
            for hole in HOLES
        ]
    )
