"""An estimate as text (a table) and for programs (a dictionary)."""

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from skin_ident.estimators.estimate import HALF_95, Estimate
from skin_ident.estimators.figures import figures, plus_minus
from skin_models.parameter import Parameter
from skin_models.words import counted

WIDTH = 110  # characters of a line
SHOWN = 8  # sessions whose telemetry is printed


def as_table(estimate: Estimate) -> str:
    """Value, ± (95 %), unit and verdict of every parameter; then the residual by channel, reasons, and warnings."""
    head = f"{estimate.method}: {counted(len(estimate.sessions), 'session')} ({', '.join(estimate.sessions)})"
    rows = [_row(estimate, p) for p in estimate.parameters]
    left = [f"  {name:<10} rms {r.rmse:.4g} {r.unit}   R² {r.r2:.5f}" for name, r in estimate.residuals.items()]
    why = [f"  {p.name:<9} {estimate.verdicts[p.name].word}: {estimate.verdicts[p.name].sentence}" for p in estimate.parameters]
    notes = [f"note: {w}" for w in estimate.warnings]
    title = f"  {'':<9} {'value':>12} {'± 95 %':>11}  {'unit':<7} verdict"
    folded = [_folded(line) for line in why + notes]
    asked = [*_spread(estimate), *_asked_for(estimate), *_entangled(estimate)]
    left += _held_back(estimate)
    return "\n".join([head, *_telemetry(estimate), title, *rows, *asked, "what the fit leaves:", *left, "why:", *folded])


def _held_back(estimate: Estimate) -> list[str]:
    """Lines on the samples that a robust loss has held back, by channel."""
    loss = estimate.notes.get("loss", {"name": "", "channels": {}})
    each = {name: f"{counted(t['held_back'], 'sample')} beyond 4 times {t['scale']:.3g}" for name, t in loss["channels"].items()}
    return [f"  {name:<10} loss {loss['name']}: {what} {estimate.residuals[name].unit} held back" for name, what in each.items()]


def _telemetry(estimate: Estimate) -> list[str]:
    """One line for each of the first few sessions: rate, depth range, speed and contact; then latencies and sinusoids."""
    sessions = estimate.notes.get("telemetry", {})
    lines = [
        f"  {name}: {t['rate_hz']:.5g} Hz, depth over {t['depth_range_mm']:.3g} mm, {t['speed_rms_mm_per_s']:.3g} mm/s rms, "
        f"in contact {100 * t['in_contact']:.0f} % of the time"
        for name, t in list(sessions.items())[:SHOWN]
    ]
    lines += [f"  … and {len(sessions) - SHOWN} more"] * (len(sessions) > SHOWN)
    return lines + _latencies(estimate) + _sinusoids(estimate)


def _latencies(estimate: Estimate) -> list[str]:
    """A line with the channels' latencies behind the depth (ms), as far as the motion identifies them."""
    found = estimate.notes.get("latency_behind_depth_ms", {})
    told = [f"{name} {plus_minus(e['value'], HALF_95 * e['std'])}" for name, e in found.items() if math.isfinite(e["std"])]
    if not found:
        return []
    untold = f"; {len(found) - len(told)} not told" if told and len(told) < len(found) else ""
    return [f"  latency behind the depth, ms: {', '.join(told) or 'this motion does not tell'}{untold}"]


def _sinusoids(estimate: Estimate) -> list[str]:
    """The fitted A, B, C and t0 of eq 29, for the first few sessions."""
    found = estimate.notes.get("sinusoids", {})
    return [
        f"  {name}: x = A sin(B (t - t0)) + C with A {1e3 * s['amplitude']:.4g} mm, B {s['omega']:.5g} rad/s, "
        f"C {1e3 * s['offset']:.4g} mm, t0 {s['start']:.4g} s, missed by {1e6 * s['rms']:.2g} um rms"
        for name, s in list(found.items())[:SHOWN]
    ]


def _spread(estimate: Estimate) -> list[str]:
    """A line on the Gaussian that was fitted to the shares over the taxels' positions."""
    s = estimate.notes.get("spread")
    if not s:
        return []
    if "reason" in s:
        return [f"spread over the taxels: {s['reason']}"]
    x, y, c = (plus_minus(s[n]["value"], HALF_95 * s[n]["std"]) for n in ("x_mm", "y_mm", "c_mm"))
    return [f"spread over the taxels: centre ({x}, {y}) mm, width c {c} mm, R² {s['r2']:.4f}"]


def _entangled(estimate: Estimate) -> list[str]:
    """How well the motion separates the terms: the condition of the normal matrix, and the two most correlated parameters."""
    free = [i for i, p in enumerate(estimate.parameters) if estimate.std[p.name] > 0.0]
    head = f"condition of the normal matrix {estimate.condition:.3g}"
    if len(free) < 2:
        return [head]
    size, i, j = max((abs(estimate.correlations[i, j]), i, j) for i in free for j in free if i < j)
    sign = "-" if estimate.correlations[i, j] < 0 else ""
    return [f"{head}; strongest correlation {sign}{size:.2f}, of {estimate.parameters[i].name} and {estimate.parameters[j].name}"]


def _asked_for(estimate: Estimate) -> list[str]:
    """Bootstrap and profile intervals, where they were requested, each under a title."""
    out: list[str] = []
    drawn, profiled = estimate.notes.get("bootstrap"), estimate.notes.get("profile")
    if drawn:
        out.append(f"95 % from {drawn['runs']} bootstrap samples, stretches of {drawn['stretch_s']:.3g} s:")
        out += _ranges(drawn["ci95"])
    if profiled:
        out += ["95 % by profile likelihood:", *_ranges(profiled["ci95"])]
    return out


def _ranges(intervals: Mapping[str, Sequence[float]]) -> list[str]:
    return [f"  {name:<9} {low:.6g} … {high:.6g}" for name, (low, high) in intervals.items()]


def _row(estimate: Estimate, p: Parameter) -> str:
    low, high = estimate.interval(p.name)
    half = (high - low) / 2
    error = "" if half == 0.0 else figures(half)
    return f"  {p.name:<9} {_rounded(p.value, half):>12} {error:>11}  {p.unit:<7} {estimate.verdicts[p.name].word}"


def _rounded(value: float, half: float) -> str:
    """A value with as many digits as the uncertainty allows, and one more."""
    if half <= 0.0 or not math.isfinite(half) or value == 0.0:
        return f"{value:.4g}"
    digits = max(2, min(9, math.floor(math.log10(abs(value))) - math.floor(math.log10(half)) + 2)) if abs(value) > half else 2
    return f"{value:.{digits}g}" if abs(value) < 10**digits else f"{value:.0f}"


def _folded(line: str) -> str:
    return "\n".join(textwrap.wrap(line, WIDTH, initial_indent=line[: len(line) - len(line.lstrip())], subsequent_indent=" " * 12))


def as_dict(estimate: Estimate) -> dict[str, Any]:
    """The content of fit.json."""
    return {
        "schema": 1,
        "method": estimate.method,
        "recordings": list(estimate.sessions),
        "parameters": {p.name: _entry(estimate, p) for p in estimate.parameters},
        "correlations": {"names": [p.name for p in estimate.parameters], "matrix": estimate.correlations},
        "condition": estimate.condition,
        "degrees_of_freedom": estimate.dof,
        "residuals": {name: vars(r) for name, r in estimate.residuals.items()},
        "notes": dict(estimate.notes),
        "warnings": list(estimate.warnings),
    }


def _entry(estimate: Estimate, p: Parameter) -> dict[str, Any]:
    verdict = estimate.verdicts[p.name]
    return {
        "value": p.value,
        "unit": p.unit,
        "std": estimate.std[p.name],
        "ci95": list(estimate.interval(p.name)),
        "verdict": verdict.word,
        "because": verdict.sentence,
        "contribution_rms_n": dict(estimate.contributions[p.name]),
    }
