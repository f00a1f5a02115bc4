"""What may be wrong in a static scan, and which parameters of the family describe it."""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fitting import Member

FEWEST_DISTANCES, FEWEST_DEPTHS = 6, 4  # needed to test the shape of a spread, and a skin's force over depth


@dataclass(frozen=True)
class Candidate:
    """One cause in one form. `starts` are initial values of its parameters, relative to their neutral value (the one that removes the
    cause), in units of a typical magnitude (see `family.sizes`); `bends` says what it acts on: spread, level or reading."""

    cause: str
    where: str
    form: str
    names: tuple[str, ...]
    bends: str
    starts: tuple[tuple[float, ...], ...] = ()


CANDIDATES = (
    Candidate("spread_width", "skin", "", ("width",), "spread"),
    Candidate("spread_shape", "skin", "generalised_gaussian", ("power",), "spread", ((1.0,), (-0.7,))),
    Candidate("spread_shape", "skin", "heavy_tail", ("tail",), "spread", ((0.1,), (1.0,))),
    Candidate("spread_shape", "skin", "disc", ("disc",), "spread", ((0.8,), (1.6,))),
    Candidate("spread_shape", "skin", "flat_with_tail", ("power", "tail"), "spread", ((1.0, 2.0),)),
    Candidate("spread_shape", "skin", "polynomial", ("bend2", "bend3"), "spread"),
    Candidate("spread_shape", "skin", "quartic", ("bend2", "bend3", "bend4"), "spread"),
    Candidate("spread_depth", "skin", "", ("growth",), "spread"),
    Candidate("spread_depth", "skin", "power", ("depth_power",), "spread"),
    Candidate("off_centre", "rig", "", ("centre",), "spread", ((1.0,), (-1.0,))),
    Candidate("anisotropy", "skin", "", ("ratio",), "spread"),
    Candidate("nonlinear_stiffness", "skin", "polynomial", ("square",), "level"),
    Candidate("nonlinear_stiffness", "skin", "power", ("exponent",), "level"),
    Candidate("nonlinear_stiffness", "skin", "cubic", ("square", "cube"), "level"),
    Candidate("position_offset", "rig", "", ("shift",), "level", ((0.5,), (-0.5,))),
    Candidate("force_offset", "taxel", "", ("offset",), "reading"),
    Candidate("drift", "taxel", "", ("drift",), "reading"),
    Candidate("dead_zone", "taxel", "", ("threshold",), "reading", ((1.0,), (3.0,))),
    Candidate("saturation", "taxel", "", ("ceiling",), "reading", ((0.5,), (3.0,))),
    Candidate("parameters", "skin", "", (), "level"),
)


@dataclass(frozen=True)
class Excited:
    """What the scans excite, and what they can be compared with; this decides which causes they can test."""

    depths: int
    distances: int
    both_sides: bool
    both_directions: bool
    given_width: bool
    given_level: bool

    def why_not(self, cause: str) -> str:
        """Why a cause cannot be tested; empty where it can."""
        if cause == "spread_width" and not self.given_width:
            return "no width was given to compare with (spread_width_mm in rig.yaml): the baseline's own is fitted"
        if cause == "parameters" and not self.given_level:
            return "no model was given to compare with"
        if cause == "anisotropy" and not self.both_directions:
            return "there is no pair of scans that say they run along x and along y"
        if cause in ("spread_shape", "off_centre") and self.distances < FEWEST_DISTANCES:
            return f"there are only {self.distances} distances"
        if cause in ("spread_depth", "drift") and self.depths < 3:
            return f"there are only {self.depths} depths"
        if cause in ("nonlinear_stiffness", "position_offset") and self.depths < FEWEST_DEPTHS:
            return f"there are only {self.depths} depths"
        return ""


def excited(cells: Cells, given_width: bool, given_level: bool) -> Excited:
    """What these cells excite. `given_width` and `given_level` say whether there is a width and a level to compare with."""
    distances = max(np.unique(np.round(np.abs(cells.r[cells.scan == s]), 9)).size for s in cells.scans)
    depths = np.unique(np.round(cells.z, 9)).size
    reach = np.abs(cells.r).max()
    both = any(min(-cells.r[cells.scan == s].min(), cells.r[cells.scan == s].max()) > 0.25 * reach for s in cells.scans)
    return Excited(depths, distances, both, np.unique(cells.along[cells.along != 0.0]).size > 1, given_width, given_level)


def excited_beside(cells: Cells, start: Member) -> Excited:
    """The same for a search that begins at `start`: a parameter that is not free there was given."""
    return excited(cells, "width" not in start.free, not start.k_free)


def able(x: Excited) -> tuple[Candidate, ...]:
    """The candidates that these scans can test. A candidate of another shape frees the width too: a given width belongs to the given shape
    and means nothing for another."""
    told = (c for c in CANDIDATES if not x.why_not(c.cause) and not _too_free(c, x))
    return tuple(_with_width(c) if x.given_width and c.cause == "spread_shape" else c for c in told)


def _with_width(c: Candidate) -> Candidate:
    return replace(c, names=(*c.names, "width"), starts=tuple((*factors, 0.0) for factors in c.starts))


def _too_free(c: Candidate, x: Excited) -> bool:
    return (c.form == "cubic" and x.depths < FEWEST_DEPTHS + 2) or (c.form == "quartic" and x.distances < FEWEST_DISTANCES + 3)


def rich(x: Excited) -> tuple[str, ...]:
    """Names of all parameters that these scans excite: the richest member, from whose residual the noise is estimated."""
    names = ["width", "offset"]
    names += ["bend2", "bend3"] if x.distances >= FEWEST_DISTANCES else []
    names += ["bend4"] if x.distances >= FEWEST_DISTANCES + 3 else []
    names += ["growth", "drift"] if x.depths >= 3 else []
    names += ["square"] if x.depths >= FEWEST_DEPTHS else []
    names += ["cube"] if x.depths >= FEWEST_DEPTHS + 2 else []
    names += ["centre"] if x.both_sides else []
    return (*names, *(["ratio"] if x.both_directions else []))


def starts(c: Candidate, m: Member) -> list[Member]:
    """Initial members for the fit of a candidate, with its parameters free."""
    neutral = m.freeing(*c.names)
    if not c.starts:
        return [neutral]
    return [neutral.moved(**{n: _start(m, n, f) for n, f in zip(c.names, factors, strict=True)}) for factors in c.starts]


def _start(m: Member, name: str, factor: float) -> float:
    if name == "ceiling":  # its neutral value is infinite, so the start is below the largest reading instead
        return max(m.steps["largest"] - factor * m.steps[name], 0.1 * m.steps["largest"])
    return m.values[name] + factor * m.steps[name]
