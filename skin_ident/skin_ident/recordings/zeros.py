"""Zeros that were changed within a record. The driver reports them in `driver_state`; the parts before and after are separate records."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby, pairwise

import numpy as np

from skin_ident.recordings.decode import Topic, typestore
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.places import Places
from skin_ident.recordings.timing import Track
from skin_models.words import counted

STATE_TYPE = "skin_testbed_msgs/msg/DriverState"
INACTIVE = 0  # a state that says nothing about zeros
TOLD = (  # flag, its counter (older drivers have none), and the words for setting and for clearing it
    ("zeroed", "zero_count", "the depth was zeroed anew", "the zero of the depth was reset"),
    ("tared", "tare_count", "the loads were tared anew", "the tare of the loads was reset"),
)
NAMED = 3  # most times of one kind that a sentence gives


@dataclass(frozen=True)
class Change:
    """A change of a zero: what was done, and when (ns), by the driver's clock and by the recorder's."""

    what: str
    stamp_ns: int
    log_ns: int

    def at(self, stamped: bool) -> int:
        """Its time (ns) by the driver's clock for a topic that is `stamped`, else by the recorder's."""
        return self.stamp_ns if stamped else self.log_ns


@dataclass
class States:
    """Collects the messages in which a driver reports its state."""

    topic: Topic
    heard: list[tuple[int, bytes]] = field(default_factory=list)

    def __call__(self, places: Places, sizes: np.ndarray, log_ns: np.ndarray) -> None:
        """Take in messages of these sizes (bytes)."""
        self.heard += [(int(log), places.raw(i, size)) for i, (size, log) in enumerate(zip(sizes, log_ns, strict=True))]

    def changes(self) -> list[Change]:
        """Every change of a zero, in the order of time. The first message is latched, so it gives the state before any change."""
        try:
            store = typestore(self.topic)
        except RecordingError:  # a bag without definitions
            return []
        before, out = {}, []
        for log_ns, raw in sorted(self.heard):
            try:
                m = store.deserialize_cdr(raw, self.topic.kind)
            except Exception:  # generated code meets damaged bytes
                continue
            if m.state == INACTIVE:
                continue
            at = m.header.stamp.sec * 1_000_000_000 + m.header.stamp.nanosec
            now = {flag: (getattr(m, flag), getattr(m, count, 0)) for flag, count, *_ in TOLD}
            changed = [words if now[flag][0] else undone for flag, _, words, undone in TOLD if before.get(flag, now[flag]) != now[flag]]
            out += [Change(what, at, log_ns) for what in changed]
            before = now
        return out


def states_beside(topics: Mapping[str, Topic], read: Sequence[Topic]) -> list[States]:
    """The states of the driver of the topics that are `read`: the one in the namespace of one of them, or the only one; empty where that is
    not clear."""
    known = [t for t in topics.values() if t.kind == STATE_TYPE and t.count]
    spaces = {t.name.rpartition("/")[0] for t in read}
    beside = [t for t in known if t.name.rpartition("/")[0] in spaces]
    return [States(t) for t in (beside or known)] if len(beside or known) == 1 else []


def of_one_zero(tracks: dict[str, Track], stamped: Mapping[str, bool], changes: Sequence[Change]) -> tuple[dict[str, Track], list[str]]:
    """The tracks cut to one part between two changes of a zero, and a warning about that: the part in which the plunger is in the skin for
    longest, or, without a depth, the longest part. `stamped` says for every role whether its stamps are the driver's."""
    first = next(iter(tracks))
    t = tracks[first].t
    inside = [c for c in changes if t.size and t[0] < c.at(stamped[first]) < t[-1]]
    if not inside:
        return tracks, []
    pieces = {role: _pieces(track.t, [c.at(stamped[role]) for c in inside]) for role, track in tracks.items()}
    touched = tracks[first].blocks[0][0] > 0.0 if first == "encoder" else np.zeros(t.size, bool)
    best = max(range(len(inside) + 1), key=lambda i: (np.count_nonzero(touched & pieces[first][i]), np.count_nonzero(pieces[first][i])))
    said = f"{_said(inside, [(c.at(stamped[first]) - t[0]) * 1e-9 for c in inside])}: the parts before and after are separate records"
    kept = (t[pieces[first][best]] - t[0]) * 1e-9
    if kept.size < 2:
        raise RecordingError(f"{said}, and too short; record again")
    left = counted(t.size - kept.size, "sample")
    note = f"{said}; kept {kept[0]:.2f} to {kept[-1]:.2f} s, left {left} out"
    return {role: track.kept(pieces[role][best]) for role, track in tracks.items()}, [note]


def _pieces(t: np.ndarray, edges: list[int]) -> list[np.ndarray]:
    """Masks (N,) of the samples before, between and after the edges. A sample at an edge belongs to no part, because a tare may be taken
    back within one sample."""
    return [(t > a) & (t < b) for a, b in pairwise([-np.inf, *edges, np.inf])]


def _said(changes: Sequence[Change], seconds: list[float]) -> str:
    """`the depth was zeroed anew at 12.30 s and the loads were tared anew at 40.10 s`."""
    kinds = sorted(zip((c.what for c in changes), seconds, strict=True))
    times = {what: [f"{at:.2f}" for _, at in same] for what, same in groupby(kinds, key=lambda kind: kind[0])}
    return " and ".join(f"{what} at {', '.join(at[:NAMED] + ['…'] * (len(at) > NAMED))} s" for what, at in times.items())
