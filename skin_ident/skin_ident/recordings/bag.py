"""A rosbag2 directory or a bare MCAP file as a recording: which topic is what, and all of them on one clock."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

from skin_ident.recordings import decode
from skin_ident.recordings.assemble import Channel, assemble
from skin_ident.recordings.declared import FILE_NAME, Declared, declared_from
from skin_ident.recordings.decode import Decoded
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.storage import RawBag, RawTopic, read_mcap, read_sqlite
from skin_ident.recordings.timing import BRIDGED, Track, counted, ordered

METADATA = "metadata.yaml"
ROLES = {
    "encoder": (decode.DEPTH_TYPES, ("encoder", "depth", "position", "indentation", "joint_states")),
    "force": (decode.FORCE_TYPES, ("force", "wrench", "ft", "load_cell")),
    "taxels": (decode.TAXEL_TYPES, ("taxels", "taxel", "skin")),
}
ALIASES = {"encoder": "encoder", "depth": "encoder", "x": "encoder", "position": "encoder", "force": "force", "taxels": "taxels"}
KINDS = {"encoder": ("depth", "m"), "force": ("force", "N"), "taxels": ("taxel", "N")}
NAMED_ONLY = ("Float64", "Float32", "Float64MultiArray", "Float32MultiArray")  # too common to be taken for a force unless so called


def read_bag(path: Path, declared: Declared, topics: Mapping[str, str] | None = None, stamps: str = "header") -> Recording:
    """The recording in a bag. `topics` maps force, encoder and taxels to topic names; `stamps` is "header" or "log".

    Raises `RecordingError`.
    """
    bag = _read_files(path)
    declared = declared.filled_with(declared_from(bag.attachments[FILE_NAME].decode())) if FILE_NAME in bag.attachments else declared
    chosen = choose(path.name, bag.topics, _wishes(topics or {}))
    found = {role: decode.decode(topic, joint) for role, (topic, joint) in chosen.items()}
    warnings = [w for d in found.values() for w in d.warnings]
    tracks = {role: _track(d, stamps, warnings) for role, d in found.items()}
    declared, names = _laid_out(bag, chosen, declared)
    t, aligned = _on_one_clock(tracks, warnings)
    channels = [Channel(KINDS[r][0], n, found[r].unit or KINDS[r][1], y) for r in aligned for n, y in _named(r, aligned[r], names)]
    return assemble(path.name, t, channels, declared, (*bag.warnings, *warnings))


def is_bag(path: Path) -> bool:
    """Whether `path` is a rosbag2 directory or a storage file."""
    return path.suffix in (".mcap", ".db3") if path.is_file() else (path / METADATA).is_file() and _storage_files(path) != []


def _storage_files(folder: Path) -> list[Path]:
    """The files that the metadata of a bag names, in their order; all there are, where it names none that exists."""
    try:
        content = yaml.safe_load((folder / METADATA).read_text(encoding="utf-8"))
        names = [Path(str(n)).name for n in content["rosbag2_bagfile_information"]["relative_file_paths"]]
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError):
        names = []
    named = [folder / n for n in names if (folder / n).is_file()]
    return named or sorted(p for p in folder.iterdir() if p.suffix in (".mcap", ".db3"))


def _read_files(path: Path) -> RawBag:
    whole = RawBag()
    for file in [path] if path.is_file() else _storage_files(path):
        part = (read_sqlite if file.suffix == ".db3" else read_mcap)(file, _of_use)
        for name, topic in part.topics.items():
            known = whole.topics.setdefault(name, replace(topic, log_ns=[], messages=[]))
            known.log_ns += topic.log_ns
            known.messages += topic.messages
        whole.attachments |= part.attachments
        whole.warnings += part.warnings
    return whole


def _of_use(name: str, kind: str) -> bool:
    return kind in (*decode.FORCE_TYPES, *decode.DEPTH_TYPES, *decode.TAXEL_TYPES, decode.LAYOUT_TYPE)


def _wishes(topics: Mapping[str, str]) -> dict[str, str]:
    unknown = [role for role in topics if role not in ALIASES]
    if unknown:
        raise RecordingError(f"--topics knows force, encoder and taxels, not {unknown[0]!r}")
    return {ALIASES[role]: topic for role, topic in topics.items()}


def choose(name: str, topics: Mapping[str, RawTopic], wishes: Mapping[str, str]) -> dict[str, tuple[RawTopic, str]]:
    """Topic and joint for every role that the bag can fill. Raises `RecordingError` where it can fill none, or the choice is not clear."""
    chosen = {}
    for role in ROLES:
        if role in wishes:
            chosen[role] = _wished(name, topics, role, wishes[role])
        elif (topic := _obvious(topics, role)) is not None:
            chosen[role] = (topic, "")
    empty = [topic.name for topic, _ in chosen.values() if not topic.messages]
    chosen = {role: pair for role, pair in chosen.items() if pair[0].messages}
    if not chosen:
        held = ", ".join(sorted(topics)) or "no topic of a known type"
        nothing = f"{', '.join(empty)} hold no message" if empty else f"has no force, encoder or taxels topic; it holds {held}"
        raise RecordingError(f"{name} {nothing}; name them with --topics force=/ft encoder=/x taxels=/skin")
    return chosen


def _wished(name: str, topics: Mapping[str, RawTopic], role: str, wish: str) -> tuple[RawTopic, str]:
    title, _, joint = wish.partition(":")
    found = topics.get(title) or topics.get("/" + title)
    if found is None:
        raise RecordingError(f"{name} has no topic {title} of a known type for {role}; it holds {', '.join(sorted(topics)) or 'none'}")
    if found.type not in ROLES[role][0]:
        raise RecordingError(f"topic {title} has type {found.type}; {role} is read from {', '.join(ROLES[role][0])}")
    return found, joint


def _obvious(topics: Mapping[str, RawTopic], role: str) -> RawTopic | None:
    kinds, words = ROLES[role]
    fitting = [t for t in topics.values() if t.type in kinds and not t.name.endswith("_truth")]
    for word in words:
        named = [t for t in fitting if t.name.rpartition("/")[2] == word]
        if len(named) > 1:
            raise RecordingError(f"more than one topic could be {role}: {', '.join(t.name for t in named)}; choose with --topics")
        if named:
            return named[0]
    own = [t for t in fitting if t.type.rpartition("/")[2] not in NAMED_ONLY]
    return own[0] if len(own) == 1 else None


def _track(d: Decoded, stamps: str, warnings: list[str]) -> Track:
    if not d.stamped:
        warnings.append(f"{d.topic} carries no time stamps: the times at which it was recorded were used")
    return ordered(Track(d.stamp_ns, d.rows), d.topic)


def _on_one_clock(tracks: dict[str, Track], warnings: list[str]) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Stamps (N,) s from the first sample on, and every role's rows (R, N) at them; NaN where a role has no sample near."""
    warnings += [f"{role}: {w}" for role, track in tracks.items() for w in track.warnings]
    base = next(iter(tracks.values())).t
    overlap = (base >= max(k.t[0] for k in tracks.values())) & (base <= min(k.t[-1] for k in tracks.values()))
    if overlap.sum() < 2:
        raise RecordingError("the topics were not recorded at the same time, or their stamps come from different clocks")
    base = base[overlap]
    if (~overlap).sum() > BRIDGED:
        warnings.append(f"{counted((~overlap).sum(), 'sample')} before or after one of the topics left out")
    rows = {role: _aligned(role, track, base, warnings) for role, track in tracks.items()}
    return (base - base[0]) * 1e-9, rows


def _aligned(role: str, track: Track, base: np.ndarray, warnings: list[str]) -> np.ndarray:
    """The rows of a track at the stamps `base` (ns): its own samples where stamps agree, else linear in between."""
    at = np.clip(np.searchsorted(track.t, base), 0, track.t.size - 1)
    same = track.t[at] == base
    if same.mean() > 0.9:
        return np.where(same, track.rows[:, at], np.nan)
    before = np.clip(at - 1, 0, None)
    gap = track.t[at] - track.t[before]
    near = gap <= (BRIDGED + 1.5) * np.median(np.diff(track.t))
    period_ms = np.median(np.diff(track.t)) * 1e-6
    warnings.append(f"{role}: interpolated to the instants of the first channel (its own samples come every {period_ms:.4g} ms)")
    seconds = (track.t - base[0]) * 1e-9
    return np.array([np.where(near, np.interp((base - base[0]) * 1e-9, seconds, row), np.nan) for row in track.rows])


def _laid_out(bag: RawBag, chosen: Mapping[str, tuple[RawTopic, str]], declared: Declared) -> tuple[Declared, tuple[str, ...]]:
    layouts = [t for t in bag.topics.values() if t.type == decode.LAYOUT_TYPE and t.messages]
    if "taxels" not in chosen or len(layouts) != 1:
        return declared, ()
    names, positions = decode.layout(layouts[0])
    return declared.filled_with(Declared(taxel_positions_mm=positions)), names


def _named(role: str, rows: np.ndarray, names: tuple[str, ...]) -> list[tuple[str, np.ndarray]]:
    if role != "taxels":
        return [(role, rows[0])]
    usual = names if len(names) == len(rows) and len(set(names)) == len(names) else [f"taxel_{i}" for i in range(len(rows))]
    return list(zip(usual, rows, strict=True))
