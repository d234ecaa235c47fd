"""Which setting is wrong, by trying each on the last second: no ROS, no files, no clock."""
