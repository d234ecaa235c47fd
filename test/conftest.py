"""ROS settings of every test: this machine only, a domain of its own, set before rclpy loads."""

import os
import tempfile

from peg_on_hole_ros.edges.local_dds import environment, free_domain

os.environ.update(environment(free_domain()))
os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp(prefix="peg_on_hole_log_"))
