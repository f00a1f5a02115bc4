"""The charts of a recording in time: measured against simulated, and what is left."""

import numpy as np

from skin_ident.criticism.outcome import ScanTrace, Trace
from skin_ident.report.markup import Safe, el
from skin_ident.report.numbers import amount, scale
from skin_ident.report.plot import Axis, Line, axis, legend, plot
from skin_ident.report.shapes import Binned, binned, residuals, span_of, spectrum, thinned
from skin_ident.report.words import channel

KEY = legend(("measured", "measured"), ("before", "simulated before"), ("after", "simulated after"))
KEY_LEFT = legend(("before", "before"), ("after", "after"))


def overlay(trace: Trace, row: int, unit: str, cut: slice, buckets: int) -> Safe:
    """Measured against simulated over residual, for the samples in `cut`."""
    t = trace.t[cut]
    x = Axis(float(t[0]), float(t[-1]), "time, s")
    curves = [trace.measured[row][cut], trace.baseline[row][cut], trace.extended[row][cut]]
    factor, name = scale(np.nanmax(np.abs(curves[0]), initial=0.0), unit)
    left = [curves[0] - curves[1], curves[0] - curves[2]]
    small, small_name = scale(max((float(np.nanmax(np.abs(r), initial=0.0)) for r in left), default=0.0), unit)
    kinds = ("measured", "before", "after")
    names = ("measured", "simulated before", "simulated after")
    top = [Line(*thinned(t, factor * y, buckets), k, n) for y, k, n in zip(curves, kinds, names, strict=True)]
    below = [Line(*thinned(t, small * r, buckets), k, n) for r, k, n in zip(left, kinds[1:], ("before", "after"), strict=True)]
    return el(
        "div",
        plot(top, x, axis([line.y for line in top], f"{channel(trace.channels[row])}, {name}"), "tall"),
        plot(below, x, axis([line.y for line in below], f"measured − simulated, {small_name}", zero=True), "low"),
        class_="pair",
    )


def against_motion(trace: Trace, row: int, unit: str) -> list[Safe]:
    """Residual against depth and against speed; nothing where the recording has neither."""
    before, after = residuals(trace, row)
    panels = []
    for quantity, label, factor in ((trace.depth, "depth, mm", 1e3), (trace.speed, "speed, mm/s (pressing is positive)", 1e3)):
        found = span_of(quantity)
        if found is not None:
            panels.append(_against(quantity, (before, after), found, label, factor, unit, trace.speed))
    return [p for p in panels if p is not None]


def _against(quantity, pair, found, label: str, factor: float, unit: str, speed) -> Safe | None:
    low, high = found
    split = label.startswith("depth") and np.isfinite(speed).all()
    sides = ((speed > 0, "", "pressing"), (speed < 0, " dashed", "releasing")) if split else ((np.isfinite(pair[0]), "", ""),)
    parts: list[tuple[Binned, str, str]] = []
    for r, kind in zip(pair, ("before", "after"), strict=True):
        for inside, style, name in sides:
            parts.append((binned(quantity[inside], r[inside], low, high), kind + style, f"{kind} {name}".strip()))
    parts = [p for p in parts if p[0].centre.size]
    if not parts:
        return None
    scaled, printed = scale(max(float(np.max(np.abs(np.r_[b.low, b.high]))) for b, _, _ in parts), unit)
    lines = [Line(factor * b.centre, scaled * b.median, kind, name) for b, kind, name in parts]
    bands = [_band(b, factor, scaled, kind) for b, kind, _ in parts] if not split else []
    y = axis([line.y for line in [*bands, *lines]], f"measured − simulated, {printed}", zero=True)
    title = f"against {label.partition(',')[0]}" + (": pressing (solid) and releasing (dashed)" if split else "")
    return plot([*bands, *lines], Axis(factor * low, factor * high, label), y, "square", title)


def _band(b: Binned, factor: float, scaled: float, kind: str) -> Line:
    x = factor * np.concatenate([b.centre, b.centre[::-1]])
    return Line(x, scaled * np.concatenate([b.low, b.high[::-1]]), f"{kind} band", "")


def against_frequency(trace: Trace, row: int, unit: str) -> Safe | None:
    """Spectrum of the residual before and after."""
    if trace.t.size < 64:
        return None
    lines, densities = [], []
    for r, kind in zip(residuals(trace, row), ("before", "after"), strict=True):
        f, d = spectrum(trace.t, r)
        lines.append(Line(f, d, kind, kind))
        densities.append(d[d > 0])
    held = np.concatenate(densities)
    if not held.size:
        return None
    high = float(held.max())
    low = max(float(held.min()), 1e-4 * high)
    low, high = (low, high) if high > 10 * low else (high / 10.0, high)
    x = Axis(float(lines[0].x[0]), float(lines[0].x[-1]), "frequency, Hz", log=True)
    y = Axis(low / 1.3, high * 1.3, f"measured − simulated, {unit}/√Hz", log=True)
    return plot(lines, x, y, "square", "against frequency")


def scan_panels(scan: ScanTrace, most: int = 12) -> list[Safe]:
    """Force against distance, one panel for each depth (evenly picked where there are more than `most`)."""
    picked = np.unique(np.linspace(0, scan.depth.size - 1, min(most, scan.depth.size)).round().astype(int))
    factor, name = scale(np.nanmax(np.abs(scan.measured), initial=0.0), "N")
    x = axis([1e3 * scan.distance], "distance from the taxel's centre, mm")
    return [_scan_panel(scan, i, x, factor, name) for i in picked]


def _scan_panel(scan: ScanTrace, i: int, x: Axis, factor: float, name: str) -> Safe:
    r = 1e3 * scan.distance
    lines = [
        Line(*_known(r, factor * scan.baseline[i]), "before", "simulated before"),
        Line(*_known(r, factor * scan.extended[i]), "after", "simulated after"),
        Line(*_known(r, factor * scan.measured[i]), "measured dots", "measured"),
    ]
    y = axis([line.y for line in lines], f"sensed force, {name}", zero=True)
    return plot(lines, x, y, "square", f"depth {amount(scan.depth[i], 'm')}")


def scan_left(scan: ScanTrace) -> list[Safe]:
    """What is left of a scan, against distance (all depths) and against depth (root mean square of each)."""
    before, after = scan.measured - scan.baseline, scan.measured - scan.extended
    factor, name = scale(np.nanmax(np.abs(before), initial=0.0), "N")
    r, d = 1e3 * scan.distance, 1e3 * scan.depth
    faint = [Line(*_known(r, factor * row), f"{kind} thin", kind) for left, kind in ((before, "before"), (after, "after")) for row in left]
    sizes = [Line(*_known(d, factor * np.sqrt(np.nanmean(e**2, axis=1))), k, k) for e, k in ((before, "before"), (after, "after"))]
    x = axis([r], "distance from the taxel's centre, mm")
    return [
        plot(
            faint,
            x,
            axis([line.y for line in faint], f"measured − simulated, {name}", zero=True),
            "square",
            "against distance: a line per depth",
        ),
        plot(sizes, axis([d], "depth, mm"), axis([s.y for s in sizes], f"typical error, {name}", zero=True), "square", "against depth"),
    ]


def _known(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    keep = np.isfinite(y)
    return x[keep], y[keep]
