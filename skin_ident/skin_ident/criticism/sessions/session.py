"""A recording prepared for comparison: motion for the simulation, measured channels in the common band."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.cutoff import ALONE, Common, beside_rounding
from skin_ident.criticism.sessions.load import load_of
from skin_ident.criticism.vocabulary import Key
from skin_ident.recordings.staircase import drawn_again
from skin_models.dispersion import Dispersion
from skin_models.effects.time_shift import TimeShift
from skin_models.operators.lagging import lagged
from skin_models.signals import Motion, motion

NOMINAL = 1e4  # N/m, stiffness assumed for a skin known only by ratios
FITTED, KEPT = " (two blocks in three)", " (every third block)"  # suffixes of the names of the two parts of a lone session


@dataclass(frozen=True)
class Session:
    """One recording as the criticism uses it.

    `channels` names the rows of `measured` (C, n), newtons, low-passed and decimated. `raw` (C, N) is as recorded; `bridged` is the same
    with bad samples replaced by straight lines. `weight` (C, n) is 1 where a sample is trusted and 0 where telemetry has ruled it out.
    `drive` (N,) is the applied force of a force-to-force test, which has no depth: `motion` is then only a first guess (see
    `motion_under`).
    """

    name: str
    motion: Motion
    channels: tuple[str, ...]
    raw: np.ndarray
    bridged: np.ndarray
    band: Band
    t: np.ndarray
    measured: np.ndarray
    weight: np.ndarray
    period: float  # s, recorded sampling period
    drive: np.ndarray | None = None
    drive_noise: float = 0.0  # N rms, its white noise in the common band
    drive_step: float = 0.0  # N, spacing of its levels; 0 where none are seen
    spread: np.ndarray | None = None  # (T,), factors on `Model.shares`, where sessions press at different places
    contact: np.ndarray | None = None  # (2,) m, contact position of this session in the taxels' frame
    beyond: np.ndarray | None = None  # (C, N) N, added to the simulation: by a recorded twin (see `twin`), zeros of tares, courses
    course: np.ndarray | None = None  # (C, N) N, the part of `beyond` that is a finding
    stuck: Mapping[str, float] = field(default_factory=dict)  # N, constant readings of channels that respond to nothing
    clipped: frozenset[str] = frozenset()  # channels whose record itself shows a ceiling
    heaviest: float = 0.0  # kg, upper bound of the model's mass, which is fitted, too; 0: the mass is held (see `search.weighing`)
    hung: float = 0.0  # kg, a mass that hangs on the load cell, whose inertia it feels while a tare took the weight away
    late: float = 0.0  # s, by which depth acts later than it was read (see `search.lateness`); the motion is that of depth as it acts
    skin: Mapping[str, float] = field(default_factory=dict)  # factors on k1, b1, k2, b2 in this session (see `search.own_skin`)
    lacks: frozenset[Key] = frozenset()  # causes of the model, with places, that this session does not have (see `search.partly`)
    pinned: bool = False  # whether the shares are as `spread` says, and not fitted in each session (see `own_shares`)
    reference: int | None = None  # the taxel whose share is held at `spread` in any case
    steps: tuple[float, ...] = ()  # N, spacing of each channel's levels; 0 where none are seen
    depth_noise: float = 0.0  # m rms, white noise of the encoder beyond rounding to its steps
    rarest: float = 0.0  # s, longest sampling period of the recordings that it is compared with

    @cached_property
    def n_taxels(self) -> int:
        """The number of channels that are taxels."""
        return sum(c.startswith("taxel") for c in self.channels)

    @property
    def taxel_rows(self) -> slice:
        """The rows of `measured` that are taxels: the last ones, or none."""
        return slice(len(self.channels) - self.n_taxels, None)

    @cached_property
    def answers(self) -> np.ndarray:
        """Mask (C,) of the channels that are not stuck."""
        return np.array([c not in self.stuck for c in self.channels])

    @property
    def longest_period(self) -> float:
        """Longest sampling period, s, of this session and those that it is compared with: what is bounded by it is the same in all."""
        return max(self.period, self.rarest)

    @property
    def seconds(self) -> float:
        """Trusted duration, s, of the channel that has the longest."""
        return float(np.max(np.count_nonzero(self.weight, axis=1), initial=0)) * self.band.spacing

    @property
    def free_mass(self) -> bool:
        """Whether the model's mass is fitted, too."""
        return self.heaviest > 0.0

    @cached_property
    def load(self) -> np.ndarray:
        """Load (C, n), N, of each channel at every kept sample, including those that are not compared."""
        return load_of(replace(self.band, seen=None).thin(self.bridged), np.interp(self.t, self.motion.t, self.motion.x), self.band.spacing)

    def with_own_of(self, other: "Session") -> "Session":
        """The session with what was found to be particular to `other`, which has the same samples: its part beyond the model, a mass that
        hangs, a depth that is late, its shares, its skin, and the causes that it lacks."""
        names = ("beyond", "course", "hung", "skin", "lacks", "spread", "reference")
        return replace(delayed(self, other.late), **{name: getattr(other, name) for name in names})


def prepare(recording, bad: np.ndarray | None = None, common: Common = ALONE) -> Session:
    """Makes a session from a recording. `bad` (C, N) marks samples that are not trusted (bridged before filtering). `common` is what it
    shares with the recordings that it is compared with."""
    band = Band(recording.dt, common.cutoff, max(common.slowest, recording.longest_period))
    drive = band.smooth(recording.force) if recording.depth is None else None
    moved = drawn_again(recording.depth) if drive is None else recording.force / NOMINAL
    s = motion(recording.t, band.smooth(moved), band.speed(moved))
    channels, raw = stacked(recording)
    bad = np.zeros(raw.shape, bool) if bad is None else bad
    bridged = with_lines(raw, bad)
    weight = (band.thin(bad.astype(float)) < 0.02).astype(float)
    session = Session(
        name=recording.name,
        motion=s,
        channels=channels,
        raw=raw,
        bridged=bridged,
        band=band,
        t=band.times(recording.t),
        measured=band.thin(bridged),
        weight=weight,
        period=recording.dt,
        spread=recording.spread,
        contact=1e-3 * np.array(recording.declared.contact_of(recording.name), float),
        steps=tuple(recording.step(c) or 0.0 for c in channels),
        rarest=common.rarest,
    )
    if drive is None:
        return replace(session, depth_noise=beside_rounding(recording))
    return replace(session, drive=drive, drive_noise=band.white(recording.force), drive_step=recording.step("force") or 0.0)


def with_zeros(sessions: list[Session], values: dict[str, np.ndarray]) -> list[Session]:
    """The sessions with `values` (C, N) N by name added to their simulation that are no finding, such as zeros that tares leave: the
    baseline is compared with them as well."""
    return [replace(s, beyond=values[s.name] + (0.0 if s.beyond is None else s.beyond)) for s in sessions]


def with_reference(sessions: list[Session]) -> list[Session]:
    """The sessions with the taxel of the largest share as reference, of those that answer, set in the session where it occurs, if all have
    shares of their own; else unchanged."""
    if any(s.spread is None for s in sessions):
        return sessions
    shares = [s.spread * s.answers[s.taxel_rows] for s in sessions]
    first = max(range(len(sessions)), key=lambda i: shares[i].max())
    return [replace(s, reference=int(np.argmax(y)) if i == first else None) for i, (s, y) in enumerate(zip(sessions, shares, strict=True))]


def silenced(session: Session, channels: Iterable[str]) -> Session:
    """The session in which these channels are stuck at zero."""
    stuck = dict.fromkeys(channels, 0.0)
    own = np.array([c in stuck for c in session.channels])
    return replace(session, measured=np.where(own[:, None], 0.0, session.measured), stuck=stuck) if stuck else session


def weighed(sessions: list[Session], heaviest: float = np.inf) -> list[Session]:
    """The sessions with the mass among their model's unknowns, at most `heaviest`, kg; with 0 it is held."""
    return [replace(s, heaviest=heaviest) for s in sessions]


def hung(sessions: list[Session], mass: float) -> list[Session]:
    """The sessions with a mass, kg, that hangs on the load cell and is known."""
    return [replace(s, heaviest=0.0, hung=mass) for s in sessions]


def weighed_as(sessions: list[Session], other: Session) -> list[Session]:
    """The sessions with the mass as in another one: held, as an unknown, or hanging on the load cell."""
    return [replace(s, heaviest=other.heaviest, hung=other.hung) for s in sessions]


def delayed(session: Session, time: float) -> Session:
    """The session with depth that acts later by a `time`, s, than it was read."""
    if time == session.late:
        return session
    x = TimeShift("clock_depth", delay=time - session.late).batch(session.motion.x, session.motion)
    return replace(session, motion=session.motion.at_depth(x), late=time)


def having_all(sessions: list[Session]) -> list[Session]:
    """The sessions, all of which have every cause again."""
    return [replace(s, lacks=frozenset()) for s in sessions]


def longest(sessions: list[Session]) -> Session:
    """The session of the longest duration."""
    return max(sessions, key=lambda s: s.motion.t[-1] - s.motion.t[0])


def without(sessions: list[Session], one: Session) -> tuple[list[Session], Session]:
    """The other sessions, with a reference of their own, and session `one` without a reference."""
    return with_reference([s for s in sessions if s is not one]), replace(one, reference=None)


def of_recovery(tau: float) -> Dispersion:
    """Skin of stiffness `NOMINAL` that recovers with the time constant tau, s. What its taxels sense does not matter here and is zero."""
    return Dispersion(m=0.0, b1=0.0, k1=0.0, b2=tau * NOMINAL, k2=NOMINAL)


def motion_under(session: Session, skin: Dispersion) -> Motion:
    """The depth of the session. In a force-to-force test it is the depth to which the applied force F presses this skin,

        tau x' + x = F / k,    tau = (b1 + b2) / (k1 + k2), k = k1 + k2      (thesis eq 27 without the mass, so that eq 32 follows)

    starting from rest and exact for a force that is linear between samples. The skin and its taxels are assumed to recover in the same way
    where nothing presses.
    """
    if session.drive is None:
        return session.motion
    k, tau, dt = skin.k1 + skin.k2, skin.recovery, session.motion.dt
    target = session.drive / k
    if tau <= 0.0:
        return replace(motion(session.motion.t, target), pressed=True)
    x = lagged(target, tau, dt)
    return replace(motion(session.motion.t, x, (target - x) / tau), pressed=True)


def stacked(recording) -> tuple[tuple[str, ...], np.ndarray]:
    """Names and rows (C, N) of the channels to be explained: force (unless it drives the test), then taxels in the recording's order."""
    force = [("force", recording.force)] if recording.force is not None and recording.depth is not None else []
    rows = force + [(f"taxel_{i}", y) for i, y in enumerate(recording.taxels)]
    return tuple(name for name, _ in rows), np.array([y for _, y in rows], float)


def with_lines(rows: np.ndarray, bad: np.ndarray) -> np.ndarray:
    """`rows` (C, N) with the `bad` samples (C, N) replaced by straight lines between good neighbours; rows that are all bad stay as they
    are."""
    out = rows.copy()
    for row, b in zip(out, bad, strict=True):
        if b.any() and not b.all():
            row[b] = np.interp(np.flatnonzero(b), np.flatnonzero(~b), row[~b])
    return out
