"""Describes samples that are wrong: how many, and how far from the samples around them; and tells whether they remain."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.telemetry.as_read import AsRead, calm_lines
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.estimators.scale import rms
from skin_ident.recordings.recording import Recording
from skin_ident.stretches import runs

LASTING, TURNING = 8, 0.15  # samples of an excursion, and share of them that change sign, from which it is as noise
HELD = "the same motions again with its cable and connector held still, and a look at single samples of the bursts"
LEFT = 0.5  # share of their size that outliers must keep under the extended model


@dataclass(frozen=True)
class Marks:
    """Masks of one channel, one for every session: of excursions (`away`), of frozen runs (`still`), and of runs of one reading that noise
    would not make (`unlikely`)."""

    away: list[np.ndarray]
    still: list[np.ndarray]
    unlikely: list[np.ndarray]

    def on_grid(self, lines: list[AsRead]) -> "Marks":
        """The same at the samples of the recordings, for a channel that is read at the instants of these `lines`."""
        return Marks(*([line.on_grid(m) for line, m in zip(lines, masks, strict=True)] for masks in (self.away, self.still, self.unlikely)))


def told(
    names: list[str],
    channel: str,
    lines: list[AsRead],
    read: Marks,
    away: list[np.ndarray],
    still: list[np.ndarray],
    n_taxels: int,
    dts: list[float],
) -> Symptom | None:
    """The symptom of a channel's excursions `away` and frozen runs `still`, masks (N,) of each session, sampled every `dts` s; None where
    there are none. `read` marks the same and more at the channel's own readings."""
    ran = [line.kept(a, grid) for line, a, grid in zip(lines, read.away, away, strict=True)]
    stood = [line.kept(f | u, grid) for line, f, u, grid in zip(lines, read.still, read.unlikely, still, strict=True)]
    masks = [a | s for a, s in zip(ran, stood, strict=True)]
    count, total = int(sum(m.sum() for m in masks)), sum(m.size for m in masks)
    if count == 0:
        return None
    wrong = np.concatenate([away_from_around(line.e, m) for line, m in zip(lines, masks, strict=True)])
    largest = float(np.max(np.abs(wrong)))
    runs_still, runs_away = (sum(runs(m)[0].size for m in each) for each in (stood, ran))
    what = [
        f"{runs_away} excursions that jump away and back" if runs_away else "",
        f"{runs_still} runs of frozen samples during a movement" if runs_still else "",
    ]
    belong = f"{count} of {total} samples of {channel} belong to {' and '.join(w for w in what if w)}"
    why = f"{belong}, up to {largest:.3g} N from what the samples around them say"
    bad = {(name, channel): a | s for name, a, s in zip(names, away, still, strict=True) if (a | s).any()}
    rate = (runs_still + runs_away) / sum(a.size * dt for a, dt in zip(away, dts, strict=True))
    parameters = {"rate": quantity(rate, "1/s"), "size": quantity(rms(wrong), "N")}
    evidence, where = {"why": why, "count": count, "excursions": runs_away}, sensor_of(channel, n_taxels)
    rivals = {"alternatives": (("noise", where),), "apart": HELD} if _are_noisy(lines, ran, runs_away) else {}
    return Symptom("outliers", where, (channel,), parameters, evidence, bad, **rivals)


def _are_noisy(lines: list[AsRead], away: list[np.ndarray], excursions: int) -> bool:
    """Whether `excursions` in number, masks (N,) of each session, last for many samples and change sign within as noise does: a sensor
    whose noise is loud at times."""
    count = sum(int(a.sum()) for a in away)
    if not count or count < LASTING * excursions:
        return False
    signs = [np.sign(away_from_around(line.e, a)) for line, a in zip(lines, away, strict=True)]
    turns = sum(np.count_nonzero(s[1:] != s[:-1]) for s in signs)
    return turns > TURNING * count


def are_left(symptom: Symptom, recordings: Sequence[Recording], row: int, residuals: list[np.ndarray]) -> bool:
    """Whether the outliers lie as far from the samples around them as before, in `row` of the extended model's residuals (C, N) for each
    recording. With a depth that gives way a landing is no longer a jump away and back."""
    channel = symptom.channels[0]
    lines = calm_lines(channel, row, recordings, residuals, [np.ones(len(r), bool) for r in recordings])
    masks = [symptom.bad.get((r.name, channel), np.zeros(len(r), bool)) for r in recordings]
    wrong = np.concatenate([_farthest(line, m) for line, m in zip(lines, masks, strict=True)])
    return wrong.size == 0 or rms(wrong) > LEFT * symptom.parameters["size"]["value"]


def _farthest(line: AsRead, on_grid: np.ndarray) -> np.ndarray:
    """How far a residual lies off in the samples of a mask (N,). With readings of its own, which may be more, it is the farthest in each
    run."""
    mask = line.beside(on_grid)
    if line.own is None:
        return away_from_around(line.e, mask)
    far = np.zeros(mask.size)
    far[mask] = np.abs(away_from_around(line.e, mask))
    return np.array([far[a:b].max() for a, b in zip(*runs(mask), strict=True)])


def away_from_around(e: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """How far the residual e (N,) lies, in the samples of the mask (N,), from straight lines between the good samples around them."""
    if not mask.any() or mask.all():
        return np.zeros(0)
    good = np.flatnonzero(~mask)
    return e[mask] - np.interp(np.flatnonzero(mask), good, e[good])
