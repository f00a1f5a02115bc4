"""Combines samples by their stamps as they arrive, feeds them to the recursive estimator, and counts what is late, lost or not a number."""

from dataclasses import dataclass, field, replace

import numpy as np

from skin_ident.estimators import recursive
from skin_ident.estimators.recursive import Live, Memory, State

LEARN = 20  # samples from which sampling period and number of taxels are learnt
KEEP = 4000  # most samples of a topic that wait for those of the other topics
LOST = 10.5  # periods: after a longer pause the filter starts anew
FARTHEST, STRONGEST = 10.0, 1e5  # m, N: larger values are invalid


@dataclass(frozen=True)
class Health:
    """The state of the input since the last update: rate (Hz), jitter of the stamps (s, std), samples that were used, left `alone` (without
    partners in the other topics) or `invalid`, pauses, taxels that sent no numbers (`silent`), and known topics that sent nothing
    (`unheard`). `used_ever` counts the samples used since the beginning.
    """

    rate: float = 0.0
    jitter: float = 0.0
    used: int = 0
    alone: int = 0
    invalid: int = 0
    pauses: int = 0
    silent: int = 0
    unheard: tuple[str, ...] = ()
    used_ever: int = 0


@dataclass
class LiveFit:
    """Call `offer` for every message, and `update` from time to time. Not thread-safe."""

    window: float
    cutoff: float
    mass: float
    memory: Memory | None = None
    state: State | None = None
    live: Live | None = None
    newest: int = 0  # ns; 0 where no sample was used yet, or none since the clock was set back
    health: Health = field(default_factory=Health)
    _heard: dict[str, dict[int, np.ndarray]] = field(default_factory=lambda: {"encoder": {}, "force": {}, "taxels": {}})
    _offered: set[str] = field(default_factory=set)  # topics that sent something since the last update
    _rows: list[np.ndarray] = field(default_factory=list)
    _last: np.ndarray | None = None
    _seen: int = 0
    _dropped: int = 0
    _left_out: int = 0  # messages of a topic that had sent nothing when the others were learnt
    _behind: int = 0  # consecutive samples with stamps older than the newest
    _set_back: bool = False  # whether the clock was, since the last sample that was used
    _odd: int = 0  # consecutive samples with another number of taxels

    def offer(self, role: str, stamp_ns: int, values: np.ndarray) -> None:
        """Take one message of the encoder ((1,), m), the force ((1,), N) or the taxels ((T,), N)."""
        self._left_out += self.memory is not None and role not in self._roles
        self._offered.add(role)
        waiting = self._heard[role]
        waiting[stamp_ns] = np.asarray(values, float)
        if len(waiting) > KEEP:
            waiting.pop(next(iter(waiting)))
            self._dropped += role == "encoder"

    def update(self) -> Live | None:
        """Process all complete samples, and return the current estimate, or None where it is too early or nothing moves."""
        unheard = () if self.memory is None else tuple(role for role in self._roles if role not in self._offered)
        self.health = replace(self.health, rate=0.0, jitter=0.0, used=0, alone=self._dropped, invalid=0, pauses=0, unheard=unheard)
        self._dropped = 0
        self._offered.clear()
        rows = self._complete()
        if len(rows) >= 2:
            self._absorb(rows)
        if self.state is not None:
            self.live = recursive.estimate(self.memory, self.state)
        return self.live

    def _complete(self) -> list[tuple[int, np.ndarray]]:
        """Samples (stamp, values) whose stamp all sending topics share, in the order of time."""
        speaking = [role for role, heard in self._heard.items() if heard]
        if "encoder" not in speaking or len(speaking) < 2 or min(len(self._heard[r]) for r in speaking) < 2:
            return []
        if self._left_out >= LEARN:  # a topic that was discovered late: start anew with it
            self.memory = self.state = self.live = self._last = None
            self._left_out = 0
        if self.memory is not None:
            speaking = self._roles
        common = sorted(set.intersection(*(set(self._heard[role]) for role in speaking)))
        if self.memory is None and len(common) < LEARN:
            return []
        rows = [(stamp, np.concatenate([self._heard[role][stamp] for role in speaking])) for stamp in common]
        self._forget(common[-1] if common else 0)
        return self._learnt(rows, speaking) if rows else []

    @property
    def _roles(self) -> list[str]:
        """The topics that were learnt."""
        return ["encoder", *["force"] * self.memory.force, *["taxels"] * (self.memory.taxels > 0)]

    def _forget(self, newest: int) -> None:
        for role, heard in self._heard.items():
            late = [stamp for stamp in heard if stamp <= newest]
            for stamp in late:
                del heard[stamp]
            if role == "encoder":
                self._seen = len(late)

    def _learnt(self, rows: list[tuple[int, np.ndarray]], speaking: list[str]) -> list[tuple[int, np.ndarray]]:
        """Learn sampling period and number of taxels from the first samples; return the rows of that width that are newer than the last."""
        if self._odd >= LEARN:  # another array, or the first message was not like the others
            self.memory = self.state = self.live = self._last = None
        if self.memory is None:
            dt = float(np.median(np.diff([stamp for stamp, _ in rows]))) * 1e-9
            force = "force" in speaking
            taxels = rows[-1][1].size - 1 - force
            cutoff = min(self.cutoff, 0.2 / dt)
            self.memory = Memory(dt, cutoff, self.window, self.mass, force, taxels)
            self.state = recursive.initial(self.memory)
        width = 1 + self.memory.force + self.memory.taxels
        alike = [(stamp, row) for stamp, row in rows if row.size == width]
        self._odd = 0 if alike else self._odd + len(rows)
        rows = alike
        fitting = [(stamp, row) for stamp, row in rows if stamp > self.newest]
        self._behind = 0 if fitting else self._behind + len(rows)
        if self._behind >= LEARN:  # the clock was set back, as when a bag is replayed, or one stamp was in the future
            fitting, self.newest, self._behind, self._set_back = rows, 0, 0, True
        self.health = replace(self.health, alone=self.health.alone + self._seen - len(fitting))
        return fitting

    def _absorb(self, rows: list[tuple[int, np.ndarray]]) -> None:
        stamps = np.array([stamp for stamp, _ in rows])
        values = np.array([row for _, row in rows]).T
        limits = np.where(np.arange(len(values)) == 0, FARTHEST, STRONGEST)
        values[~(np.abs(values) <= limits[:, None])] = np.nan
        silent = ~np.isfinite(values).any(axis=1)
        silent[: 1 + self.memory.force] = False
        values[silent] = 0.0  # one dead taxel must not stop the others
        finite = np.isfinite(values).all(axis=0)
        pauses = 0
        for stamp, value in zip(stamps[finite], values.T[finite], strict=True):
            pauses += self._after(int(stamp), value)
        self._flush()
        periods = np.diff(stamps) * 1e-9
        self.health = replace(
            self.health,
            rate=float(periods.size / max(periods.sum(), 1e-9)),
            jitter=float(np.std(periods)),
            used=int(finite.sum()),
            invalid=int((~finite).sum()),
            pauses=pauses,
            silent=int(silent.sum()),
            used_ever=self.health.used_ever + int(finite.sum()),
        )

    def _after(self, stamp: int, value: np.ndarray) -> bool:
        """Queue one sample, with short losses before it interpolated. Returns True after a pause, where the filter starts anew."""
        steps = (stamp - self.newest) * 1e-9 / self.memory.dt if self.newest else 1.0
        paused = self._set_back or steps > LOST
        if paused:
            self._flush()
            self.state = recursive.restarted(self.memory, self.state)
        missing = 0 if paused or self._last is None else max(0, round(steps) - 1)
        self._rows += [self._last + (value - self._last) * (i + 1) / (missing + 1) for i in range(missing)]
        self._rows.append(value)
        self._last, self.newest, self._set_back = value, stamp, False
        return paused

    def _flush(self) -> None:
        if self._rows:
            self.state = recursive.absorb(self.memory, self.state, np.array(self._rows).T)
            self._rows = []
