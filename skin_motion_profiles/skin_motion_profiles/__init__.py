"""Trajectories sampled in position, velocity and acceleration, without ROS."""
