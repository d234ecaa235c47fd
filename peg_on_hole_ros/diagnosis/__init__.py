"""Which stated settings the data contradict: no ROS, no files, no clock."""
