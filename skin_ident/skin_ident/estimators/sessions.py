"""Prepares recordings for linear estimation: motion, contact, and measured channels as rows of one filtered, decimated system."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.prefilter import Prefilter, prefilters_for
from skin_ident.quality import Quality, inspected
from skin_ident.recordings.carried import said_of
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.staircase import drawn_again
from skin_ident.stretches import runs
from skin_models.dispersion import Dispersion
from skin_models.signals import GRAVITY, Motion, motion
from skin_models.words import counted

FELT = 0.02  # share of the largest force above which there is contact
NO_STRETCH = "no stretch of it is long and good enough to be fitted"


@dataclass(frozen=True)
class Session:
    """One recording. `force` (n,) or None and `taxels` (T, n) are rows of the prefilter; `motion` and `felt` are at full rate.

    `raw` are force and taxels at full rate, as measured. `parts` are the stretches of trusted rows. `felt` (N,) masks the samples at which
    the load cell (or, without one, the strongest taxel) reads more than `FELT` of its largest force. `live` are the indices, among all
    `total` taxels, of those that take part: the taxels in newtons that ever change.
    """

    name: str
    motion: Motion
    force: np.ndarray | None
    taxels: np.ndarray
    felt: np.ndarray
    prefilter: Prefilter
    parts: tuple[slice, ...]
    quality: Quality
    raw: tuple[np.ndarray, ...] = ()
    live: tuple[int, ...] = ()
    total: int = 0

    @property
    def believed(self) -> np.ndarray:
        """A mask (N,) of the samples from which trusted rows are computed."""
        out = np.zeros(len(self.motion), bool)
        for part in self.parts:
            out[self.prefilter.samples(part)] = True
        return out

    def with_rows(self, samples: Sequence[np.ndarray]) -> "Session":
        """The session with rows computed from other samples (N,) of force and taxels; `raw` stays as measured."""
        rows = [self.prefilter.rows(y) for y in samples]
        force = None if self.force is None else rows.pop(0)
        return replace(self, force=force, taxels=np.array(rows).reshape(self.taxels.shape))

    def columns(self, recovery: float | None = None) -> np.ndarray:
        """The columns (n, 4) of `terms` as rows of the prefilter."""
        return self.prefilter.rows(self.terms(recovery)).T

    def columns_left_alone(self, recovery: float | None) -> np.ndarray:
        """The columns (n, 2) of `left_alone` as rows of the prefilter."""
        return self.prefilter.rows(self.left_alone(recovery)).T

    def terms(self, recovery: float | None = None) -> np.ndarray:
        """Speed, depth, acceleration, -gravity (4, N) at full rate, each zero where plunger and skin do not touch.

        `recovery` is the time constant b / k of the whole skin (s): a plunger that retracts faster than the skin recovers parts from it.
        While it is unknown (None), there is contact where a force is felt.
        """
        s = self.motion
        contact = self.felt & (s.x > 0.0) if recovery is None else s.x > 0.0
        if recovery is not None and recovery > 0.0:
            contact = _like(recovery).contact(s)
        return np.array([s.v, s.x, s.a, np.full_like(s.x, -GRAVITY)]) * contact

    def left_alone(self, recovery: float | None) -> np.ndarray:
        """Speed and depth (2, N) of skin that the plunger has left behind and that recovers by itself; zero where it is touched."""
        if not recovery or recovery < 0.0:
            return np.zeros((2, len(self.motion)))
        surface = _like(recovery).surface(self.motion)
        depth = surface.depth * ~surface.touched
        return np.array([-depth / recovery, depth])


def _like(recovery: float) -> Dispersion:
    """Skin that recovers with this time constant, s."""
    return Dispersion(b1=recovery, k1=1.0, b2=0.0, k2=0.0)


def prepare(recordings: Sequence[Recording], motions: Sequence[Motion] | None = None) -> tuple[list[Session], tuple[str, ...]]:
    """The recordings as sessions with a common low-pass, and warnings. `motions` replaces the measured motion. Raises `FitError`."""
    if not recordings:
        raise FitError("there is no recording to fit")
    lacking = [r.name for r in recordings if r.depth is None]
    if lacking:
        raise FitError(f"{', '.join(lacking)}: no depth was recorded, and this fit needs it")
    _same_channels(recordings)
    if all(np.ptp(r.depth) == 0.0 for r in recordings):
        raise FitError(f"{recordings[0].name}: the depth never changes: without motion nothing can be identified")
    looked = [inspected(r) for r in recordings]
    for r, _, q in looked:
        if q.impossible:
            raise FitError(f"{r.name}: {q.impossible}")
    recordings = [r.warned(*q.warnings) for r, _, q in looked]
    prefilters = prefilters_for([(drawn_again(r.depth), r.dt) for r in recordings])
    warnings = tuple(said_of(r.name, w) for r in recordings for w in r.warnings)
    live = live_taxels(recordings)
    each = zip(recordings, prefilters, looked, strict=True)
    sessions = [_session(r, prefilter, good, q, live) for r, prefilter, (_, good, q) in each]
    if motions is not None:
        sessions = [replace(s, motion=m) for s, m in zip(sessions, motions, strict=True)]
    return sessions, warnings


def live_taxels(recordings: Sequence[Recording]) -> tuple[int, ...]:
    """Indices of taxels in newtons that change in every recording. Raises `FitError` where all of them are dead, or the load cell is."""
    in_newtons = [i for i in range(len(recordings[0].taxels)) if all(r.taxel_units[i] == "N" for r in recordings)]
    still = [r.name for r in recordings if r.force is not None and np.ptp(r.force) == 0.0]
    if still:
        raise FitError(f"{still[0]}: the force never changes: the load cell is dead, or was not recorded; leave it out")
    live = tuple(i for i in in_newtons if all(np.ptp(r.taxels[i]) > 0.0 for r in recordings))
    if in_newtons and not live:
        raise FitError(f"{recordings[0].name}: no taxel ever changes, so what is sensed is not known; for a material test leave them out")
    return live


def _session(r: Recording, prefilter: Prefilter, good: np.ndarray, quality: Quality, live: tuple[int, ...]) -> Session:
    taxels = r.taxels[list(live)]
    s = _moving(r, prefilter)
    if not np.any(s.x > 0.0):
        raise FitError(f"{r.name}: the plunger never touches the skin (depth > 0 nowhere); set the encoder's zero at the surface")
    rows = prefilter.rows
    parts = stretches(rows((~good).astype(float)) < 1e-3, prefilter.fewest)
    if not parts:
        raise FitError(f"{r.name}: {NO_STRETCH}{because(r)}")
    force = None if r.force is None else rows(r.force)
    felt = _felt(r, taxels, prefilter)
    raw = (*(() if r.force is None else (r.force,)), *taxels)
    told = (quality, raw, live, len(r.taxels))
    return Session(r.name, s, force, rows(taxels) if taxels.size else np.empty((0, 0)), felt, prefilter, parts, *told)


def _moving(r: Recording, prefilter: Prefilter) -> Motion:
    """The smoothed motion at the recording's stamps, which may be uneven. The other channels need no even stamps: the model's equation is
    linear and holds at every sample, so it holds for any weighted sum of samples."""
    if not r.uneven:
        return motion(r.t, prefilter.smooth(drawn_again(r.depth)))
    grid = np.linspace(r.t[0], r.t[-1], len(r))
    s = motion(grid, prefilter.smooth(drawn_again(np.interp(grid, r.t, r.depth))))
    return replace(s, t=r.t, **{name: np.interp(r.t, grid, getattr(s, name)) for name in "xva"})


def because(r: Recording) -> str:
    """The recording's warnings in brackets, to follow an error message; empty where there are none."""
    return f" ({'; '.join(r.warnings)})" if r.warnings else ""


def _felt(r: Recording, taxels: np.ndarray, prefilter: Prefilter) -> np.ndarray:
    if r.force is None and not taxels.size:
        return np.ones(len(r), bool)
    main = prefilter.smooth(r.force if r.force is not None else taxels[np.argmax(np.ptp(taxels, axis=1))])
    return main > FELT * main.max()


def stretches(good: np.ndarray, least: int) -> tuple[slice, ...]:
    """Runs of at least `least` consecutive good rows."""
    return tuple(slice(int(a), int(b)) for a, b in zip(*runs(good), strict=True) if b - a >= least)


def _same_channels(recordings: Sequence[Recording]) -> None:
    first = recordings[0]
    for r in recordings[1:]:
        if (r.force is None, len(r.taxels)) != (first.force is None, len(first.taxels)):
            raise FitError(
                f"{first.name} has {counted(len(first.taxels), 'taxel')}{' and force' if first.force is not None else ''}, {r.name} has "
                f"{counted(len(r.taxels), 'taxel')}{' and force' if r.force is not None else ''}: fit them apart"
            )
