"""Where the pure parts meet the world: ROS, bags, files, plots."""
