"""Courses: what belongs to one session alone (zeros, slopes, delays and depths that changed before or during it), and the gate they must
pass.

- `kinds`: which courses there are: carrier, shape in time, and the cause that each stands for
- `carriers`: what one unit of a zero, slope, delay or zero of depth changes in the channels
- `ground`: the sessions that courses are fitted to, what is left of them, and what a course adds there
- `course`: courses fitted to sessions, with the moments at which they step or bend
- `run`: a course so fitted, and whether it is more than good hardware does
- `waves`: zeros and slopes that wander smoothly throughout a session, told from noise of long memory
- `gate`: whether a course predicts the blocks between those that it was fitted to
- `left_by_tare`: how far off a tare leaves a zero
- `tare`: zeros of that size in all channels, fitted together
- `thinning`: courses fitted together, and the steps of them that are needed
- `words`: a course in words and numbers
"""
