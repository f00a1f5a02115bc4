"""The rig: one small interface, simulated, replayed, or reached over ROS."""
