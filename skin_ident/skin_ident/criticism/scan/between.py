"""Whether several scans agree in size; if not, the taxel's gain changed between them, or the skin's stiffness did.

The model fits a stiffness to every scan, so that scans of different samples can be fitted together. A taxel that reads 5 % more in the
second scan would therefore go unnoticed. A static scan cannot tell the taxel's gain from the skin's stiffness, but one taxel under one skin
has one of each. So where one rig.yaml describes the scans and they differ by more than a taxel's repeatability, `gain_error` is named,
with the stiffness as its rival. Where nothing says that the scans are of one skin, a difference is only a warning.

Repeatability: slopes of taxels measured again agree to 0.3 % to 4.6 % (thesis Table 3-1: within a day, over several days), their maker
states 2.5 % of full scale (thesis 3.3.1). Samples differ by 10 % (thesis Table 4-4).
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.fault import Fault
from skin_ident.criticism.scan.faults import Looked
from skin_ident.criticism.scan.fitting import Member, by_size, tangents
from skin_ident.criticism.scan.noise import slope_of
from skin_ident.criticism.scan.search import Search
from skin_ident.criticism.scan.whitening import Noise
from skin_ident.criticism.telemetry.symptom import quantity
from skin_ident.recordings.declared import Declared
from skin_ident.spread_scan import SpreadScan

CLEAR = 4.0  # standard errors by which two sizes must differ
REPEATS = 0.025  # relative repeatability of a taxel in the thesis; smaller differences are not reported
FEWEST_DEPTHS = 3  # different depths that a scan needs to tell its size from its zeros
STEPS = 3  # Gauss-Newton iterations; few suffice because a reading is nearly linear in the force
ZEROS = ("shift", "offset")  # parameters fitted to each scan separately
CHANGED = "the gain of the taxel changed in between, or the stiffness of the skin did (another sample, place or day)"


@dataclass(frozen=True)
class Sizes:
    """Sizes (S,) of scans under one shape, N at the deepest depth, and their standard errors (S,)."""

    value: np.ndarray
    std: np.ndarray

    def against_first(self) -> tuple[np.ndarray, np.ndarray]:
        """By how much each scan reads more than the first one, relative, and its standard error, both (S,)."""
        ratio, share = self.value / self.value[0], self.std / np.abs(self.value)
        return ratio - 1.0, np.where(np.arange(ratio.size) > 0, np.abs(ratio) * np.hypot(share, share[0]), 0.0)


def between_scans(looked: Looked, found: Search, scans: list[SpreadScan], held: list[SpreadScan], cells: Cells | None) -> Looked:
    """`looked` with one more fault or warning where scans differ in size. Held-out scans, whose cells are `cells`, are compared too."""
    m = found.extended.member
    if len(scans) + len(held) < 2 or not found.baseline.member.k_free or np.any(m.k <= 0.0):
        return looked
    every = [*_believed(scans, looked.cells), *_believed(held, cells)]
    more, std = sizes_of([part for _, part in every], m, found.noise.noise).against_first()
    odd = np.flatnonzero((np.abs(more) > CLEAR * std) & (np.abs(more) > REPEATS))
    if not odd.size:
        return looked
    names = [s.name for s, _ in every]
    told = "; ".join(_told(names[0], names[i], more[i], std[i]) for i in odd)
    if not same_skin([s.declared for s, _ in every]):
        said = "nothing says that they are of one taxel under one skin (a rig.yaml beside both would)"
        return replace(looked, warnings=(*looked.warnings, f"{told}: {CHANGED}; {said}"))
    parameters = {f"change_{names[i]}": {**quantity(more[i], "1"), "std": float(std[i])} for i in odd}
    why = f"{told}, though one rig.yaml describes them: {CHANGED}"
    nowhere = np.zeros(len(looked.every), bool)
    return replace(looked, faults=(*looked.faults, Fault("gain_error", "taxel", why, nowhere, parameters, (("parameters", "skin"),))))


def _believed(scans: list[SpreadScan], cells: Cells | None) -> list[tuple[SpreadScan, Cells]]:
    """Each scan with its trusted cells; scans without any are left out."""
    parts = [] if cells is None else [(s, cells.only(cells.scan == i)) for i, s in enumerate(scans)]
    return [(s, part) for s, part in parts if len(part)]


def _told(first: str, name: str, more: float, std: float) -> str:
    way = "more" if more > 0.0 else "less"
    return f"{name} reads {100 * abs(more):.1f} +- {100 * std:.1f} % {way} than {first}, whatever zeros of force and depth they have"


def sizes_of(parts: list[Cells], m: Member, noise: Noise) -> Sizes:
    """The size of every scan by generalised least squares. Each scan gets its own zeros of depth and force; all else is as in `m`."""
    found = [_size(part, m, noise) for part in parts]
    return Sizes(np.array([k for k, _ in found]), np.array([std for _, std in found]))


def _size(cells: Cells, m: Member, noise: Noise) -> tuple[float, float]:
    """Size and standard error for the cells of one scan. The error is infinite where too few depths tell a size from a zero."""
    alone = replace(cells, scan=np.zeros(len(cells), int))
    own, covariance = Member(m.values, np.array([float(np.mean(m.k))]), m.free, m.scale, m.steps), np.zeros((3, 3))
    for _ in range(STEPS):
        shared = {"slope": slope_of(own, alone), "through": own.through(alone), "weight": np.ones(len(cells))}
        whitener = replace(noise, **shared, row=cells.row, column=cells.column).whitener()
        J = whitener.apply(np.hstack([by_size(own, alone), tangents(own, alone, ZEROS) * [own.steps[name] for name in ZEROS]]))
        covariance = np.linalg.pinv(J.T @ J)
        change = covariance @ (J.T @ whitener.apply(alone.y - own.predict(alone)))
        zeros = {name: own.values[name] + d * own.steps[name] for name, d in zip(ZEROS, change[1:], strict=True)}
        own = replace(own.moved(**zeros), k=own.k + change[0])
    known = np.unique(cells.z).size >= FEWEST_DEPTHS
    return float(own.k[0]), float(np.sqrt(covariance[0, 0])) if known else float("inf")


def same_skin(declared: list[Declared]) -> bool:
    """Whether one rig.yaml describes all scans: there is one, and its content (the place included) is the same for all."""
    bare = [replace(d, warnings=()) for d in declared]
    return bare[0] != Declared() and all(d == bare[0] for d in bare)
