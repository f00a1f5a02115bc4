"""The rigs that need no ROS: simulated, and a recording replayed."""
