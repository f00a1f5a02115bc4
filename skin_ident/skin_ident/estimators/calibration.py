"""Straight lines for calibration: newtons per volt of a taxel against the load cell (thesis eq 26, Table 3-1), and newtons per metre of
any force against the depth (Table 3-2). Their standard errors allow for residuals that are coloured by hysteresis and drift.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.regression import Block, regress
from skin_ident.recordings.recording import Recording

ALL = np.ones(1)  # no low-pass
SUNK, FELT = 0.1e-3, 0.02  # m that a plunger moves in skin and not on a bare taxel, while there is more than this share of the load
FEWEST = 20  # samples of a session
LEAST_RANGE = 5.0  # times the residual's rms: the load must make y vary by more than this


@dataclass(frozen=True)
class Line:
    """y = slope (x - zero): slope and its standard error; zero in the unit of x; rms of y about the line; R²; samples."""

    slope: float
    slope_std: float
    zero: float
    rms: float
    r2: float
    samples: int


class Lines(dict[str, Line]):
    """Lines by channel; `notes` name the channels and sessions that have none, and why."""

    def __init__(self, lines: Mapping[str, Line], notes: Sequence[str]) -> None:
        super().__init__(lines)
        self.notes = tuple(notes)


def fit_line(x: Sequence[np.ndarray], y: Sequence[np.ndarray], through_zero: bool = False) -> Line:
    """The line through sessions x, y of (N_s,) each. `through_zero` leaves the zero at 0. Raises `FitError` where x or y never changes,
    or y hardly with x."""
    if any(a.shape != b.shape or a.size < FEWEST for a, b in zip(x, y, strict=True)):
        raise FitError(f"a line needs matching rows of at least {FEWEST} samples")
    if np.ptp(np.concatenate(x)) == 0.0 or np.ptp(np.concatenate(y)) == 0.0:
        raise FitError("it never changes: it is dead, or nothing acted on it")
    columns = [a[:, None] if through_zero else np.column_stack([np.ones(a.size), a]) for a in x]
    fit = regress([[Block(b, h, ALL) for b, h in zip(y, columns, strict=True)]])
    c, residual, whole = fit.coefficients[0], np.concatenate(fit.residuals[0]), np.concatenate(y)
    slope, rms = float(c[-1]), float(np.sqrt(np.mean(residual**2)))
    if abs(slope) * np.ptp(np.concatenate(x)) <= LEAST_RANGE * rms:
        raise FitError("the two hardly go together: the load is too small, or the wrong channels were named")
    zero = 0.0 if through_zero else float(-c[0] / slope)
    r2 = 1.0 - float(np.mean(residual**2)) / max(float(np.var(whole)), 1e-300)
    return Line(slope, float(np.sqrt(fit.covariance[-1, -1])), zero, rms, r2, whole.size)


def _each(channels: Mapping[str, tuple[Sequence[np.ndarray], Sequence[np.ndarray]]], notes: Sequence[str] = ()) -> Lines:
    """A line for every channel that has one, from its x and y by session. Raises `FitError` where none has."""
    found, told = {}, list(notes)
    for name, (x, y) in channels.items():
        try:
            found[name] = fit_line(x, y)
        except FitError as error:
            told.append(f"{name} has no line: {error}")
    if not found:
        raise FitError("; ".join(told))
    return Lines(found, told)


def calibrate(recordings: Sequence[Recording]) -> Lines:
    """Newtons per volt of every taxel that is in volts, against the load cell over all sessions. Raises `FitError` where none has a
    slope."""
    first = recordings[0]
    names = [n for n, unit in zip(first.taxel_names, first.taxel_units, strict=True) if unit == "V"]
    if not names:
        mine = [n for n, c in first.declared.calibration.items() if {c.channel, n.removesuffix("_V")} & {*first.taxel_names}]
        done = f"rig.yaml calibrates {', '.join(mine)} already, take that out first" if mine else "there is nothing to calibrate"
        raise FitError(f"{first.name} has no taxel in volts: {done}")
    for r in recordings:
        if r.force is None or not set(names) <= set(r.taxel_names):
            raise FitError(f"{r.name} lacks a load cell, or one of {', '.join(names)}: a calibration needs both together")
    forces = [r.force for r in recordings]
    if np.ptp(np.concatenate(forces)) == 0.0:
        raise FitError("the force never changes: the load cell is dead, or there was no load to calibrate against")
    return _each({n: ([r.taxels[r.taxel_names.index(n)] for r in recordings], forces) for n in names})


def direct_load(recordings: Sequence[Recording]) -> list[str]:
    """A warning that a calibration holds for the bare taxel only; through skin the load cell feels what goes round the taxel, too. None
    where every recording has a depth and shows that the taxel was bare."""
    bare = "lay a known load on the bare taxel for its own slope"
    deep = max((_sunk(r) for r in recordings), default=0.0)
    if deep < SUNK and all(r.depth is not None for r in recordings):
        return []
    if deep < SUNK:
        return [f"through skin the slope holds the share of the load that goes round the taxel, too: {bare}"]
    return [
        f"the plunger goes {1e3 * deep:.2g} mm deep while it presses, as through skin: part of the load then goes round the taxel, and the "
        f"slope is too large by that part; {bare}"
    ]


def _sunk(r: Recording) -> float:
    """How far the plunger moves while the load cell feels it, m; 0 where no depth was recorded."""
    felt = r.force - r.force.min() > FELT * np.ptp(r.force)
    return float(np.ptp(r.depth[felt])) if r.depth is not None and felt.any() else 0.0


def stiffness(recordings: Sequence[Recording]) -> Lines:
    """Newtons per metre of every force against the depth, over all sessions, where the plunger touches. Raises `FitError` where none has a
    slope."""
    lacking = [r.name for r in recordings if r.depth is None]
    if lacking:
        raise FitError(f"{', '.join(lacking)}: no depth was recorded")
    pressed = [r for r in recordings if np.count_nonzero(r.depth > 0.0) >= FEWEST]
    if not pressed:
        raise FitError("the plunger never touches the skin (depth > 0 nowhere): set the encoder's zero at the surface")
    depths = [r.depth[r.depth > 0.0] for r in pressed]
    if np.ptp(np.concatenate(depths)) == 0.0:
        raise FitError("the depth never changes while the plunger touches: press to several depths")
    notes = [f"{r.name} is left out: the plunger does not touch the skin" for r in recordings if r not in pressed]
    return _each({n: (depths, [r.channels[n][r.depth > 0.0] for r in pressed]) for n in first_channels(recordings)}, notes)


def first_channels(recordings: Sequence[Recording]) -> list[str]:
    """The channels that every recording has."""
    return [n for n in recordings[0].channels if all(n in r.channels for r in recordings)]


def as_rig_yaml(lines: dict[str, Line]) -> str:
    """The calibration as an entry of rig.yaml."""
    rows = [
        f"  {n}: {{slope_n_per_v: {line.slope:.6g}, zero_v: {line.zero:.6g}}}  # ± {2 * line.slope_std:.2g} N/V"
        for n, line in lines.items()
    ]
    return "\n".join(["calibration:", *rows, ""])
