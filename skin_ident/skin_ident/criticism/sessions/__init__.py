"""Recordings prepared for comparison: the motion that drives the simulation, and every measured channel in one common band."""
