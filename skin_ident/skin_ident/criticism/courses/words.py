"""Courses in words and numbers."""

import numpy as np

from skin_ident.criticism.courses.carriers import DELAY, DEPTH, DRIVE, DRIVEN, SLOPE, ZERO
from skin_ident.criticism.courses.kinds import BEND, CONSTANT, STEPS, Course
from skin_ident.criticism.said import Said

SIZES = {  # format of a step's size, and the factor from SI to its unit
    SLOPE: ("{:+.1f} %", 1e2),
    DEPTH: ("{:+.1f} µm", 1e6),
    DELAY: ("{:+.2f} ms", 1e3),
    ZERO: ("{:+.3g} N", 1.0),
    DRIVE: ("{:+.3g} N", 1.0),
    DRIVEN: ("{:+.1f} %", 1e2),
}
UNITS = {SLOPE: "1", DRIVEN: "1", DEPTH: "m", DELAY: "s"}  # units of the values; all others are in N
START_S = 5.0  # s, from the start of a session, within which a step counts as how the session began


def said_of(course: Course, begin: float, moments: np.ndarray, z: np.ndarray) -> Said:
    """One session's course in words and numbers: its steps one by one, or the range of a bend. `begin` is the start of the session, s."""
    unit = UNITS.get(course.carrier, "N")
    z = -z if course.carrier in (DRIVE, DRIVEN) else z  # what the load cell reads too much
    under_way = course.shape == STEPS and z.size > 0 and float(moments[-1] - begin) > START_S
    words, at = _words(course, moments, z), None if course.shape == CONSTANT else moments
    crept = (course.carrier, course.shape) == (ZERO, BEND)
    return Said.of(words, z, unit, at, under_way=under_way, crept=crept, adds_up=course.shape in (CONSTANT, STEPS))


def _words(course: Course, moments: np.ndarray, z: np.ndarray) -> str:
    size, scale = SIZES[course.carrier]
    if course.shape == BEND:
        if course.carrier == ZERO:
            return f"from {z[0]:+.3g} to {z[-1]:+.3g} N"
        return f"between {size.format(scale * z.min())} and {size.format(scale * z.max())}"
    if course.shape == CONSTANT:
        return size.format(scale * z[0])
    steps = [f"{size.format(scale * a)} at {m:.1f} s" for m, a in zip(moments, z, strict=True)]
    return ", ".join(steps) or "none"
