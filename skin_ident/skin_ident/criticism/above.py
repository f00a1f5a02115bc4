"""How far the residual lies above the noise floor, from the content of findings.json, for code that puts a verdict into words."""

from typing import Any

AT_FLOOR = 1.15  # ratio to the floor, up to which the residual counts as noise: floors of two sessions differ by as much


def above_noise(findings: dict[str, Any]) -> tuple[str, float] | None:
    """The channel whose error is the largest multiple of its noise floor, and that multiple; None where all are near it or unknown."""
    floors, gains = _mapping(findings.get("noise_floor")), _mapping(findings.get("gain_by_channel"))
    errors = _mapping(_mapping(findings.get("extended")).get("rmse"))
    ratios = {c: _ratio(floors.get(c), errors.get(c), gains.get(c)) for c in errors}
    far = {c: r for c, r in ratios.items() if r is not None and r > AT_FLOOR}
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
