"""Recordings, fits, criticism and report, without ROS."""
