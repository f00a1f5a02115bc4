"""A rosbag2 directory or a bare MCAP file as a recording: chooses the topics and brings them to one clock."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from skin_ident.recordings import decode
from skin_ident.recordings.assemble import Channels, assemble
from skin_ident.recordings.declared import FILE_NAME, Declared, declared_from
from skin_ident.recordings.decode import Decoded, Topic
from skin_ident.recordings.digits import digits_at
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.levels import steps_of
from skin_ident.recordings.readings import between
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.storage import Storage
from skin_ident.recordings.timing import BRIDGED, Track, ordered
from skin_ident.recordings.zeros import States, of_one_zero, states_beside
from skin_models.words import counted

ROLES = {
    "encoder": (decode.DEPTH_TYPES, ("encoder", "depth", "position", "indentation", "joint_states")),
    "force": (decode.FORCE_TYPES, ("force", "wrench", "ft", "load_cell")),
    "taxels": (decode.TAXEL_TYPES, ("taxels", "taxel", "skin")),
}
ALIASES = {"encoder": "encoder", "depth": "encoder", "x": "encoder", "position": "encoder", "force": "force", "taxels": "taxels"}
KINDS = {"encoder": ("depth", "m"), "force": ("force", "N"), "taxels": ("taxel", "N")}
NAMED_ONLY = ("Float64", "Float32", "Float64MultiArray", "Float32MultiArray")  # too common to be chosen by their type alone
PROBES = 100  # instants at which clocks are compared
EDGES = 0.02  # largest share of samples outside the time of another topic without a warning
OF_ITS = ":"  # between a topic and one of its joints or fields; with nothing before it, the topic is not specified
NOTHING = "holds no message"
STEP = 0.1  # s by which two clocks may move apart; recorders write in bursts
Chosen = Mapping[str, tuple[Topic, str]]
Aligned = tuple[np.ndarray, tuple[float, ...] | None, np.ndarray | None, tuple[np.ndarray, np.ndarray] | None]


def read_bag(
    path: Path, declared: Declared, topics: Mapping[str, str] | None = None, log_time: bool = False, keep: bool = False
) -> Recording:
    """The recording in a bag. `topics` maps force, encoder and taxels to topic names; `log_time` uses the times of recording instead of the
    stamps in the messages, `keep` leaves uneven stamps as they are.

    Raises `RecordingError`.
    """
    with Storage(path) as bag:
        wishes = by_role(topics or {})
        if bag.cut_off and not bag.topics:
            raise RecordingError(f"{path.name} is damaged, or cut off before its first topic: no message can be read from it; record again")
        chosen, empty = choose(path.name, bag.topics, wishes)
        if all(wish.startswith(OF_ITS) for wish in wishes.values()):
            _as_meant(path.name, chosen, empty, bag.cut_off)
        states = states_beside(bag.topics, [topic for topic, _ in chosen.values()])
        found, names, positions, warnings = _read(bag, chosen, log_time, states)
        warnings += empty
        attached = bag.attachments.get(FILE_NAME)
    if attached is not None:
        declared = declared.filled_with(declared_from(attached.decode("utf-8", "replace")))
    declared = declared.filled_with(Declared(taxel_positions_mm=positions))
    _same_clock(found, warnings)
    tracks = {role: _track(d, log_time, warnings) for role, d in found.items()}
    stamped = {role: d.stamped for role, d in found.items()}
    tracks, notes = of_one_zero(tracks, stamped, [change for each in states for change in each.changes()])
    warnings += notes
    t, aligned = _on_one_clock(tracks, warnings)
    channels = [
        Channels(KINDS[role][0], _named(role, rows, names), found[role].unit or KINDS[role][1], rows, *read)
        for role, (rows, *read) in aligned.items()
    ]
    return assemble(
        path.name, t, channels, declared, tuple(warnings), keep, tuple(track.mended for track in tracks.values()), _volts(chosen)
    )


def _volts(chosen: Chosen) -> str:
    """The option with which the taxels are read in volts; empty where their topic has none."""
    topic = chosen["taxels"][0] if "taxels" in chosen else None
    return f"--topics taxels={topic.name}{OF_ITS}voltage" if topic and "voltage" in decode.VALUES[topic.short] else ""


def _read(
    bag: Storage, chosen: Chosen, log_time: bool, states: list[States]
) -> tuple[dict[str, Decoded], tuple[str, ...], tuple, list[str]]:
    """Every chosen topic as arrays, names and positions of the taxels, and warnings."""
    gatherers = {role: decode.gatherer(*pair) for role, pair in chosen.items()}
    takers = {topic.name: gatherers[role] for role, (topic, _) in chosen.items()}
    takers |= {each.topic.name: each for each in states}
    layouts = [t for t in bag.topics.values() if t.kind == decode.LAYOUT_TYPE and t.count]
    raws: list[bytes] = []
    if "taxels" in chosen and len(layouts) == 1:
        takers[layouts[0].name] = lambda places, sizes, logs: raws.append(places.raw(len(places) - 1, sizes[-1]))
    warnings = list(bag.read(takers))
    found = {role: decode.decoded(topic, gatherers[role], log_time) for role, (topic, _) in chosen.items()}
    names, positions = decode.layout(layouts[0], raws) if raws else ((), ())
    return found, names, positions, warnings + [w for d in found.values() for w in d.warnings]


def by_role(topics: Mapping[str, str]) -> dict[str, str]:
    """Topic names by role (force, encoder, taxels), where roles may be given by an alias. Raises `RecordingError` for an unknown role, and
    for two topics of one role."""
    unknown = [role for role in topics if role not in ALIASES]
    if unknown:
        raise RecordingError(f"--topics knows force, encoder and taxels, not {unknown[0]!r}")
    given: dict[str, str] = {}
    for role in topics:
        other = given.setdefault(ALIASES[role], role)
        if other != role:
            raise RecordingError(f"--topics names {other} and {role}, which are the same: give one of them")
    return {ALIASES[role]: topic for role, topic in topics.items()}


def with_volts(topics: Mapping[str, str]) -> dict[str, str]:
    """The topics, with the raw voltage of the taxels' topic preferred to its force."""
    wish = topics.get("taxels", "")
    return {**topics, "taxels": wish if OF_ITS in wish else f"{wish}{OF_ITS}voltage"}


def choose(name: str, topics: Mapping[str, Topic], wishes: Mapping[str, str]) -> tuple[Chosen, list[str]]:
    """Topic and joint (or field) for every role that the bag can fill, and warnings, such as on topics without messages.

    Raises `RecordingError` where the bag can fill no role, or the choice is not clear.
    """
    chosen, notes = {}, []
    for role in ROLES:
        if role in wishes and not wishes[role].startswith(OF_ITS):
            chosen[role] = _wished(name, topics, role, wishes[role])
        elif (topic := _obvious(topics, role, notes)) is not None:
            chosen[role] = (topic, wishes.get(role, "").removeprefix(OF_ITS))
    empty = [topic.name for topic, _ in chosen.values() if not topic.count]
    chosen = {role: pair for role, pair in chosen.items() if pair[0].count}
    if not chosen:
        held = ", ".join(sorted(topics)) or "no topic"
        nothing = f"{', '.join(empty)} hold no message" if empty else f"has no force, encoder or taxels topic; it holds {held}"
        raise RecordingError(f"{name} {nothing}; name them with --topics force=/ft encoder=/x taxels=/skin")
    return chosen, notes + [f"topic {title} {NOTHING}" for title in empty]


def _as_meant(name: str, chosen: Chosen, empty: list[str], cut_off: bool) -> None:
    """Raises `RecordingError` where a missing topic would silently make another kind of test: a topic stayed empty, or the file is cut off
    and may have held it."""
    how = "name what to read: --topics " + " ".join(f"{role}={topic.name}" for role, (topic, _) in chosen.items())
    empty = [note for note in empty if note.endswith(NOTHING)]
    if empty:
        raise RecordingError(f"{name}: {'; '.join(empty)}; if that is as it should be, {how}")
    lacking = [role for role in ROLES if role not in chosen]
    if cut_off and lacking:
        raise RecordingError(f"{name} is cut off, and what is left holds no {' and no '.join(lacking)}; if there was none, {how}")


def _wished(name: str, topics: Mapping[str, Topic], role: str, wish: str) -> tuple[Topic, str]:
    title, _, joint = wish.partition(OF_ITS)
    found = topics.get(title) or topics.get("/" + title)
    if found is None:
        raise RecordingError(f"{name} has no topic {title}; it holds {', '.join(sorted(topics)) or 'none'}")
    if found.kind not in ROLES[role][0]:
        raise RecordingError(f"topic {title} has type {found.kind}; {role} is read from {', '.join(ROLES[role][0])}")
    return found, joint


def _obvious(topics: Mapping[str, Topic], role: str, notes: list[str]) -> Topic | None:
    """The topic with a name of the role, in the outermost namespace; else the only topic of a type that implies the role; else None."""
    kinds, words = ROLES[role]
    fitting = [t for t in topics.values() if t.kind in kinds and not t.name.endswith("_truth")]
    for word in words:
        named = [t for t in fitting if t.name.rpartition("/")[2] == word]
        outer = [t for t in named if t.name.count("/") == min(t.name.count("/") for t in named)]
        if len(outer) > 1:
            raise RecordingError(f"more than one topic could be {role}: {', '.join(t.name for t in named)}; choose with --topics")
        if len(named) > 1:
            notes.append(f"{role} is read from {outer[0].name}, not from {', '.join(t.name for t in named if t is not outer[0])}")
        if named:
            return outer[0]
    own = [t for t in fitting if t.kind.rpartition("/")[2] not in NAMED_ONLY]
    return own[0] if len(own) == 1 else None


def _same_clock(found: Mapping[str, Decoded], warnings: list[str]) -> None:
    """Compare the stamps of messages that were recorded at the same time; a constant difference is a warning. Raises `RecordingError` where
    a clock steps or drifts against another."""
    stamped = {role: d for role, d in found.items() if d.stamped and d.stamp_ns.size > PROBES}
    if len(stamped) < 2:
        return
    base = next(iter(stamped))
    for role in [r for r in stamped if r != base]:
        steady = _apart(stamped[base], stamped[role])
        if not steady.size:
            continue
        if (moved := _moved(steady)) > STEP:
            raise RecordingError(f"the clocks of {role} and {base} move apart by {moved:.3g} s: their stamps cannot be compared")
        if abs(np.median(steady)) > STEP / 2:
            warnings.append(f"{role} is stamped {np.median(steady):.3g} s later than {base} recorded at the same time")


def _apart(a: Decoded, b: Decoded) -> np.ndarray:
    """Stamps of b less those of a (K,), s, at instants while both were recorded, through a running median against outliers."""
    start, stop = max(a.log_ns.min(), b.log_ns.min()), min(a.log_ns.max(), b.log_ns.max())
    if stop <= start:
        return np.empty(0)
    when, zero = np.linspace(start, stop, PROBES), a.stamp_ns[0]
    of_a, of_b = (np.interp(when, d.log_ns[i], d.stamp_ns[i] - zero) for d in (a, b) for i in [np.argsort(d.log_ns, kind="stable")])
    return np.median(np.lib.stride_tricks.sliding_window_view((of_b - of_a) * 1e-9, 9), axis=1)


def _moved(apart: np.ndarray) -> float:
    """The lasting change, s, of the difference (K,) between two clocks. A short one does not count: where a recorder was kept from one
    topic for a while, it gets all messages afterwards, and their stamps are right."""
    tenth = max(apart.size // 10, 1)
    for_good = abs(np.median(apart[-tenth:]) - np.median(apart[:tenth]))
    return float(max(for_good, np.subtract(*np.percentile(apart, [80.0, 20.0]))))


def _track(d: Decoded, log_time: bool, warnings: list[str]) -> Track:
    if not d.stamped and not log_time:
        warnings.append(f"{d.topic} carries no time stamps: the times at which it was recorded were used")
    if d.stamped and d.stamp_ns.size > 1 and np.ptp(d.stamp_ns) == 0:
        raise RecordingError(f"{d.topic}: every message bears the same stamp; take the times of recording instead (--log-time)")
    return ordered(Track(d.stamp_ns, (d.rows,)), d.topic)


def _on_one_clock(tracks: dict[str, Track], warnings: list[str]) -> tuple[np.ndarray, dict[str, Aligned]]:
    """Stamps (N,) s, the first being 0, and every role's rows (R, N) at them; NaN where a role has no sample nearby."""
    warnings += [f"{role}: {w}" for role, track in tracks.items() for w in track.warnings]
    first = next(iter(tracks))
    base = tracks[first].t
    overlap = (base >= max(k.t[0] for k in tracks.values())) & (base <= min(k.t[-1] for k in tracks.values()))
    if overlap.sum() < 2:
        if min(track.t.size for track in tracks.values()) < 2:
            raise RecordingError(f"{' and '.join(r for r, k in tracks.items() if k.t.size < 2)}: there is only one message")
        raise RecordingError("the topics were not recorded at the same time, or their stamps come from different clocks")
    base = base[overlap]
    if (~overlap).mean() > EDGES:
        warnings.append(f"{counted((~overlap).sum(), 'sample')} before or after one of the topics left out")
    rows = {role: _aligned(role, track, first, base, warnings) for role, track in tracks.items()}
    return (base - base[0]) * 1e-9, rows


def _aligned(role: str, track: Track, first: str, base: np.ndarray, warnings: list[str]) -> Aligned:
    """The rows of a track at the stamps `base` (ns) of the `first` one: its own samples where stamps agree, else interpolated. Where they
    are interpolated, also the converter steps, the digits and the readings themselves with their instants, s; else None for these."""
    rows = track.blocks[0]
    if np.array_equal(track.t, base):
        return rows, None, None, None
    at = np.clip(np.searchsorted(track.t, base), 0, track.t.size - 1)
    same = track.t[at] == base
    if same.mean() > 0.9:
        picked = rows[:, at]
        picked[:, ~same] = np.nan
        return picked, None, None, None
    period = float(np.median(np.diff(track.t)))
    far = track.t[at] - track.t[np.clip(at - 1, 0, None)] > (BRIDGED + 1.5) * period
    warnings.append(f"{role}: interpolated to the instants of the {first} (its own samples come every {period * 1e-6:.2g} ms)")
    when, known = ((stamps - base[0]).astype(float) for stamps in (base, track.t))
    out = between(when, known, rows)
    out[:, far] = np.nan
    return out, steps_of(rows), digits_at(when, known, rows), (1e-9 * known, rows)


def _named(role: str, rows: np.ndarray, names: tuple[str, ...]) -> tuple[str, ...]:
    if role != "taxels":
        return (role,)
    return names if len(names) == len(rows) and len(set(names)) == len(names) else tuple(f"taxel_{i}" for i in range(len(rows)))
