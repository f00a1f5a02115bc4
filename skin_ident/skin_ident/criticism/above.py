"""How far what is left stands above what noise alone leaves, from the content of findings.json: for whoever puts a verdict into words."""

from typing import Any

NEAR = 1.15  # times the floor, up to which what is left is noise: so far apart are the floors of two sessions


def above_noise(findings: dict[str, Any]) -> tuple[str, float] | None:
    """The channel whose error stands furthest above its floor, and how many times that it is; None where all are near it or unknown."""
    floors, gains = _mapping(findings.get("noise_floor")), _mapping(findings.get("gain_by_channel"))
    errors = _mapping(_mapping(findings.get("extended")).get("rmse"))
    ratios = {c: _ratio(floors.get(c), errors.get(c), gains.get(c)) for c in errors}
    far = {c: r for c, r in ratios.items() if r is not None and r > NEAR}
    return max(far.items(), key=lambda q: q[1]) if far else None


def _ratio(floor: Any, errors: Any, gain: Any) -> float | None:
    rms = _number(_mapping(floor).get("rms"))
    left = [_mapping(gain).get("held_out_rmse_after"), *(_mapping(errors).get(k) for k in ("held_out", "train"))]
    known = next((e for e in map(_number, left) if e is not None), None)
    return known / rms if rms and known is not None else None


def _mapping(thing: Any) -> dict[str, Any]:
    return thing if isinstance(thing, dict) else {}


def _number(thing: Any) -> float | None:
    return float(thing) if isinstance(thing, (int, float)) and not isinstance(thing, bool) and abs(thing) < 1e150 else None
