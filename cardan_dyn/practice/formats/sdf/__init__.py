"""SDFormat: models of Gazebo and Drake, whose joints may form loops."""
