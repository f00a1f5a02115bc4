"""Courses: what belongs to one session alone (zeros, slopes, delays and depths that changed before or during it), and the gate they must
pass.
"""
