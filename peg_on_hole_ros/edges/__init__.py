"""Where the package meets ROS, files and plots; nothing is estimated here."""
