"""Recordings made ready to be compared: motion for the simulation, and every measured channel in the one common band."""
