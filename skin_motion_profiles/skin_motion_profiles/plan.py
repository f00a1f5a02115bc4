"""From entries to what a server does: stages, and for each row of profiles one motion with a smooth approach to every one of them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from skin_motion_profiles.control import Controlled
from skin_motion_profiles.entry import Entry, leaves
from skin_motion_profiles.limits import Limits
from skin_motion_profiles.moves import brake, brake_end, line
from skin_motion_profiles.profile import Profile
from skin_motion_profiles.trajectory import State, Trajectory


@dataclass(frozen=True)
class Travel:
    """How to move where no profile says how: speed (m/s) and acceleration (m/s^2)."""

    speed: float
    acceleration: float

    def within(self, limits: Limits) -> "Travel":
        """The same, but never quicker than the rig allows."""
        return Travel(min(self.speed, limits.max_speed), min(self.acceleration, limits.max_acceleration))


@dataclass(frozen=True)
class Motion:
    """A trajectory whose stretches have names: the i-th begins at `begins[i]` s."""

    trajectory: Trajectory
    names: tuple[str, ...]
    begins: tuple[float, ...]

    def name_at(self, t: float) -> str:
        """Name of the stretch that runs at time `t` (s)."""
        return self.names[max(int(np.searchsorted(self.begins, t, side="right")) - 1, 0)]


@dataclass(frozen=True)
class Stage:
    """A row of profiles that make one motion, or one entry that does not: an action or a controlled motion."""

    entries: tuple[Entry, ...]
    names: tuple[str, ...]

    @property
    def is_motion(self) -> bool:
        """Whether `motion` can be asked for."""
        return isinstance(self.entries[0], Profile)

    def motion(self, start: float, travel: Travel) -> Motion:
        """The profiles one after the other from rest at depth `start` (m), each approached from where the last one ended.

        Raises `ProfileError` for a profile that neither moves nor lasts.
        """
        pieces, begins, here, now = [], [], start, 0.0
        for profile in self.entries:
            own = profile.trajectory(here)
            approach = line(here, own.start, travel.speed, travel.acceleration)
            pieces += [*approach, *own.pieces]
            begins.append(now)
            now += own.duration + sum(p.duration for p in approach)
            here = own.end
        return Motion(Trajectory(tuple(pieces)), self.names, tuple(begins))


def stages(entry: Entry) -> tuple[Stage, ...]:
    """What is to be done, in order. Names count the entries of a battery: "3/12 sine"."""
    parts = list(leaves(entry))
    names = [f"{i}/{len(parts)} {p.label}" if len(parts) > 1 else p.label for i, p in enumerate(parts, 1)]
    return tuple(_rows(zip(parts, names, strict=True)))


def _rows(named: Iterable[tuple[Entry, str]]) -> Iterator[Stage]:
    row: list[tuple[Entry, str]] = []
    for entry, name in named:
        if isinstance(entry, Profile):
            row.append((entry, name))
            continue
        if row:
            yield Stage(*zip(*row, strict=True))
        row = []
        yield Stage((entry,), (name,))
    if row:
        yield Stage(*zip(*row, strict=True))


def rehearse(plan: Iterable[Stage], start: float, travel: Travel, limits: Limits) -> tuple[float, ...]:
    """Go through all stages from depth `start` (m) without moving anything; gives how long each will take (s), 0 where nobody knows.

    Raises `ProfileError` naming the first profile that leaves a limit, and the limit.
    """
    durations, here = [], start
    for stage in plan:
        durations.append(0.0)
        if isinstance(stage.entries[0], Controlled):
            stage.entries[0].check_limits(limits, stage.names[0])
            durations[-1] = stage.entries[0].duration
        if not stage.is_motion:
            continue
        for profile, name in zip(stage.entries, stage.names, strict=True):
            own = profile.trajectory(here)
            limits.check(own, name)
            here = own.end
        durations[-1] = stage.motion(start, travel).trajectory.duration
        start = here
    return tuple(durations)


def stop(state: State, limits: Limits, retract_to: float | None, travel: Travel, clear: float = 0.0) -> Trajectory | None:
    """From the middle of a motion to rest, and then, unless it is None, to the depth `retract_to` (m). None where already there.

    A retreat only goes backwards: to `retract_to`, or by `clear` (m) from where the plunger comes to rest if that leads higher, but then no
    higher than the limit in the air.
    """
    pieces = brake(state, limits.max_acceleration)
    if retract_to is not None:
        rest = brake_end(state, limits.max_acceleration)
        back = min(retract_to, max(rest - clear, min(limits.min_depth, rest)))
        pieces += line(rest, back, travel.speed, travel.acceleration)
    return Trajectory(pieces) if pieces else None
