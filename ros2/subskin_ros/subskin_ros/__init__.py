"""A node of ROS 2 that publishes what subskin finds."""
