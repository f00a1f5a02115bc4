"""From named channels on one clock to a `Recording`: calibration, dead taxels, signs and sizes that cannot be right."""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.recordings.declared import Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.timing import Track, even

FARTHEST = 0.2  # m: no skin is indented so deep
STRONGEST = 1e5  # N


@dataclass(frozen=True)
class Channel:
    """One measured row: kind (depth, force, taxel), name, unit (m, N or V), samples (N,)."""

    kind: str
    name: str
    unit: str
    y: np.ndarray


def assemble(name: str, t: np.ndarray, channels: list[Channel], declared: Declared, warnings: tuple[str, ...] = ()) -> Recording:
    """One evenly sampled recording from channels that share the stamps `t` (N,) s. Raises `RecordingError`."""
    channels, notes = _live(channels)
    channels, more = _calibrated(t, channels, declared)
    _no_doubles(name, channels)
    if not channels:
        raise RecordingError(f"{name} has neither depth nor force nor taxels")
    track = even(Track(t, np.array([c.y for c in channels], float)), name, declared.sample_rate_hz)
    rows = [replace(c, y=y) for c, y in zip(channels, track.rows, strict=True)]
    taxels = [c for c in rows if c.kind == "taxel"]
    recording = Recording(
        name=name,
        t=track.t,
        depth=_only(rows, "depth"),
        force=_only(rows, "force"),
        taxels=np.array([c.y for c in taxels]),
        taxel_names=tuple(c.name for c in taxels),
        taxel_units=tuple(c.unit for c in taxels),
        declared=declared,
        warnings=(*declared.warnings, *warnings, *notes, *more, *track.warnings),
    )
    return _plausible(recording)


def _only(rows: list[Channel], kind: str) -> np.ndarray | None:
    return next((c.y for c in rows if c.kind == kind), None)


def _no_doubles(name: str, channels: list[Channel]) -> None:
    for kind in ("depth", "force"):
        same = [c.name for c in channels if c.kind == kind]
        if len(same) > 1:
            raise RecordingError(f"{name} has more than one {kind}: {', '.join(same)}")


def _live(channels: list[Channel]) -> tuple[list[Channel], list[str]]:
    """Without taxels that hold hardly a number."""
    dead = [c for c in channels if c.kind == "taxel" and np.mean(np.isfinite(c.y)) < 0.5]
    return [c for c in channels if c not in dead], [f"{c.name} left out: most of its samples are no numbers" for c in dead]


def _calibrated(t: np.ndarray, channels: list[Channel], declared: Declared) -> tuple[list[Channel], list[str]]:
    """Volts to newtons where a slope is declared. Uncalibrated volts stay, with a warning; a force in volts is refused."""
    notes, out, used = [], [], set()
    for c in channels:
        known = declared.calibration.get(c.name)
        used |= {c.name} & set(declared.calibration)
        if c.unit == "V" and known is not None:
            zero = known.zero_v if known.zero_v is not None else float(np.nanmedian(c.y[t <= t[0] + 1.0]))
            meaning = known.channel or c.name
            c = Channel("force" if meaning == "force" else "taxel", meaning, "N", known.slope_n_per_v * (c.y - zero))
            if known.zero_v is None:
                notes.append(f"{meaning}: zero taken as {zero:.6g} V, the median of the first second; declare zero_v to be sure")
        elif c.unit == "V" and c.kind == "force":
            raise RecordingError(f"{c.name} is in volts: declare its slope_n_per_v under calibration in rig.yaml")
        elif c.unit == "V":
            notes.append(f"{c.name} is in volts and has no calibration: used as it is, in V")
        out.append(c)
    notes += [f"rig.yaml calibrates {name}, which is not a channel in volts here" for name in sorted(set(declared.calibration) - used)]
    return out, notes


def _plausible(r: Recording) -> Recording:
    """Refuse sizes that only a wrong unit can give; turn round a force whose compression was counted negative, and say so."""
    if r.depth is not None and np.ptp(r.depth) > FARTHEST:
        raise RecordingError(f"{r.name}: the depth spans {np.ptp(r.depth):.4g} m, more than any skin; is it in mm?")
    for label, y in r.channels.items():
        if np.max(np.abs(y)) > STRONGEST:
            raise RecordingError(f"{r.name}: {label} reaches {np.max(np.abs(y)):.4g} N, more than any load cell; check its unit")
    if r.depth is not None and r.depth.max() <= 0.0 and r.force is not None:
        r = r.warned("the plunger never goes below the surface (depth > 0): a dispersion model has nothing to be fitted to")
    still = [label for label, y in r.channels.items() if np.ptp(y) == 0.0]
    if still:
        r = r.warned(f"{', '.join(still)}: the value never changes")
    return _turned(r)


def _turned(r: Recording) -> Recording:
    against = r.depth if r.depth is not None else r.taxels.sum(axis=0) if len(r.taxels) and "V" not in r.taxel_units else None
    if r.force is None or against is None or np.ptp(against) == 0.0 or np.ptp(r.force) == 0.0:
        return r
    if np.corrcoef(r.force, against)[0, 1] > -0.5:
        return r
    return replace(r, force=-r.force).warned("force falls when the skin is pressed: its sign was turned round (compression is positive)")
