"""What needs ROS: the simulated skin's node, and what the nodes of all packages share (`node`, `parameters`, `processes`)."""
