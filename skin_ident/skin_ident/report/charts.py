"""The charts of the page: measured against simulated over time, and the residual over time, depth, speed and frequency."""

from collections.abc import Callable, Sequence

import numpy as np

from skin_ident.criticism.telling.outcome import ScanTrace, Trace
from skin_ident.report.focus import differs
from skin_ident.report.markup import Safe, el
from skin_ident.report.numbers import amount, scale
from skin_ident.report.plot import Axis, Line, axis, legend, plot
from skin_ident.report.shapes import Binned, binned, smooth, span_of, spectrum, thinned
from skin_ident.report.view import View, unit_of
from skin_ident.report.words import channel
from skin_ident.stretches import runs

CUT = 0.1  # share of an axis by which a curve must go beyond it before that is noted


def simulations(trace: Trace | ScanTrace) -> tuple[tuple[str, str, np.ndarray], ...]:
    """(kind, name, curves) of each simulation to draw; only one where the extended model equals the baseline."""
    if not differs(trace):
        return (("after", "simulated", trace.extended),)
    return (("before", "simulated before", trace.baseline), ("after", "simulated after", trace.extended))


def in_drawing_order(both: Sequence[tuple[str, str, np.ndarray]]) -> list[tuple[str, str, np.ndarray]]:
    """The simulations in drawing order: the earlier one is drawn last and dashed, so that both can be seen where they agree."""
    return [(f"{kind} over" if kind == "before" else kind, name, y) for kind, name, y in reversed(both)]


def key(trace: Trace | ScanTrace) -> Safe:
    """The legend of measured against simulated."""
    in_time = isinstance(trace, Trace)
    out = [("leftout", "not compared")] if in_time and not trace.compared.all() else []
    both = in_drawing_order(simulations(trace)) if in_time else simulations(trace)
    return legend(("measured", "measured"), *((kind, name) for kind, name, _ in both), *out)


def key_left(trace: Trace | ScanTrace) -> Safe:
    """The legend of the residuals."""
    return legend(*((kind, name.replace("simulated", "what is left").strip()) for kind, name, _ in simulations(trace)))


def overlay(trace: Trace, row: int, v: View, cut: slice, buckets: int) -> Safe:
    """A chart of measured against simulated, above a chart of the residuals (in the band in which errors are counted), for the samples in
    `cut`."""
    t, y, unit = trace.t[cut], trace.measured[row], unit_of(v, trace.channels[row])
    x = Axis(float(t[0]), float(t[-1]), "time, s")
    both = [(kind, name, curves[row]) for kind, name, curves in simulations(trace)]
    left = left_in_band(trace, row, v, cut)
    factor, printed = scale(np.nanmax(np.abs(y[cut]), initial=0.0), unit)
    small, small_printed = scale(v.loudest or max(float(np.nanmax(np.abs(r[trace.compared[cut]]), initial=0.0)) for _, _, r in left), unit)
    drawn = (("measured", "measured", y), *in_drawing_order(both))
    top = [Line(*thinned(t, factor * s[cut], buckets), kind, name) for kind, name, s in drawn]
    below = [Line(*thinned(t, small * r, buckets), kind, _briefly(name)) for kind, name, r in left]
    y_top = axis([line.y for line in top], f"{channel(trace.channels[row])}, {printed}")
    judged = trace.compared[cut]
    cut_at = " (axis cut)" if goes_beyond(left, judged) else ""
    label = f"measured − simulated{below_band(v)}, {small_printed}{cut_at}"
    y_below = axis([small * np.array(shown_range(left, judged))], label, zero=True)
    grey = _not_compared(t, judged)
    return el(
        "div",
        plot([*grey(y_top), *top], x, y_top, "tall bare"),
        plot([*grey(y_below), *below], x, y_below, "low"),
        class_="pair",
    )


def cut_off(trace: Trace, row: int, v: View, cut: slice) -> bool:
    """Whether a residual goes beyond the axis of the lower chart, which holds all compared samples and most of the others."""
    return goes_beyond(left_in_band(trace, row, v, cut), trace.compared[cut])


def left_in_band(trace: Trace, row: int, v: View, cut: slice) -> list[tuple[str, str, np.ndarray]]:
    """(kind, name, residual in the band in which errors are counted) of each simulation."""
    y = trace.measured[row]
    return [(kind, name, smooth(trace.t, y - curves[row], v.band_hz)[cut]) for kind, name, curves in simulations(trace)]


def shown_range(left: list[tuple[str, str, np.ndarray]], judged: np.ndarray) -> tuple[float, float]:
    """The range of an axis of residuals. It holds zero and all compared samples. The other samples widen it by at most its own length at
    either end; where they go further, only their middle 96 % counts."""
    every = np.stack([r for _, _, r in left])
    inside, every = every[:, judged], every[np.isfinite(every)]
    inside = inside[np.isfinite(inside)]
    if not inside.size:
        return (float(every.min()), float(every.max())) if every.size else (0.0, 0.0)
    low, high = min(0.0, float(inside.min())), max(0.0, float(inside.max()))
    further = low - (high - low), high + (high - low)
    ends = every.min(), every.max()
    if ends[0] < further[0] or ends[1] > further[1]:
        ends = np.percentile(every, [2.0, 98.0])
    return min(low, max(float(ends[0]), further[0])), max(high, min(float(ends[1]), further[1]))


def goes_beyond(left: list[tuple[str, str, np.ndarray]], judged: np.ndarray) -> bool:
    """Whether a residual goes beyond its axis (see `shown_range`) by more than CUT of the axis."""
    every = np.stack([r for _, _, r in left])
    if not np.isfinite(every).any():
        return False
    low, high = shown_range(left, judged)
    beyond = max(float(np.nanmax(every)) - high, low - float(np.nanmin(every)))
    return beyond > CUT * (high - low)


def _not_compared(t: np.ndarray, judged: np.ndarray) -> Callable[[Axis], list[Line]]:
    """A function that returns, for an axis, the shading of the stretches that were not compared."""
    pairs = [(t[a], t[min(b, t.size - 1)]) for a, b in zip(*runs(~judged), strict=True)]

    def shade(y: Axis) -> list[Line]:
        across = [np.array([a, a, b, b, np.nan]) for a, b in pairs]
        down = [np.array([y.low, y.high, y.high, y.low, np.nan])] * len(pairs)
        return [Line(np.concatenate(across), np.concatenate(down), "leftout band", "")] if pairs else []

    return shade


def below_band(v: View) -> str:
    """The band in which errors are counted, as ` below 8 Hz`; empty where it is not known."""
    return f" below {v.band_hz:.3g}\u00a0Hz" if v.band_hz else ""


def _briefly(name: str) -> str:
    return name.replace("simulated", "").strip() or "left"


def against_motion(trace: Trace, row: int, v: View) -> list[Safe]:
    """Charts of the residual against depth and against speed, as far as the recording has them."""
    panels = []
    depth, speed = (trace.depth, "depth, mm", True), (trace.speed, "speed, mm/s (pressing is positive)", False)
    for quantity, label, by_depth in (depth, speed):
        found = span_of(quantity)
        if found is not None:
            found = (max(found[0], 0.0), found[1]) if by_depth and found[1] > 0.0 else found  # in the air there is no residual
            apart = trace.speed if by_depth and np.isfinite(trace.speed).all() else None
            panels.append(_against(quantity, _left(trace, row), found, label, 1e3, v, unit_of(v, trace.channels[row]), apart))
    return [p for p in panels if p is not None]


def _left(trace: Trace, row: int) -> list[tuple[str, np.ndarray]]:
    """(kind, residual) of each simulation; NaN in samples that were not compared."""
    out = np.where(trace.compared, 0.0, np.nan)
    return [(kind, trace.measured[row] - curves[row] + out) for kind, _, curves in simulations(trace)]


def _against(quantity, pair, found, label: str, factor: float, v: View, unit: str, speed: np.ndarray | None) -> Safe | None:
    """A chart of the residuals of a `pair` of simulations over a quantity, in separate lines for pressing and releasing where `speed` is
    given."""
    (low, high), split = found, speed is not None
    sides = ((speed > 0, "", "pressing"), (speed < 0, " dashed", "releasing")) if split else ((np.isfinite(quantity), "", ""),)
    parts: list[tuple[Binned, str, str]] = []
    for kind, r in pair:
        for inside, style, name in sides:
            parts.append((binned(quantity[inside], r[inside], low, high), kind + style, f"{kind} {name}".strip()))
    parts = [p for p in parts if np.isfinite(p[0].median).any()]
    if not parts:
        return None
    scaled, printed = scale(v.loudest or max(float(np.nanmax(np.abs(np.r_[b.low, b.high]))) for b, _, _ in parts), unit)
    lines = [Line(factor * x, scaled * y, kind, name) for b, kind, name in parts for x, y in [_over(b, b.median)]]
    bands = [_band(b, factor, scaled, kind) for b, kind, _ in parts] if not split else []
    y = axis([line.y for line in [*bands, *lines]], f"measured − simulated, {printed}", zero=True)
    x = axis([line.x[np.isfinite(line.y)] for line in lines], label)
    title = f"against {label.partition(',')[0]}" + (" (dashed: releasing)" if split else "")
    return plot([*bands, *lines], x, y, "square", title)


def _over(b: Binned, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The curve of `y` (B,) over the bins that are known, from edge to edge of every stretch of them; NaN between stretches. So a bin
    between unknown ones is a short line, and a line and its band cover the same bins."""
    half, points = 0.5 * (b.centre[1] - b.centre[0]), []
    for start, stop in zip(*runs(np.isfinite(b.median)), strict=True):
        x, of = b.centre[start:stop], y[start:stop]
        points.append([np.r_[x[0] - half, x, x[-1] + half, np.nan], np.r_[of[0], of, of[-1], np.nan]])
    x, y = np.concatenate(points, axis=1)
    return x, y


def _band(b: Binned, factor: float, scaled: float, kind: str) -> Line:
    """The middle 80 % of the samples, a closed piece for every stretch of known bins."""
    (x, low), (_, high) = _over(b, b.low), _over(b, b.high)
    pieces = []
    for start, stop in zip(*runs(np.isfinite(x)), strict=True):
        there, back = np.r_[start:stop], np.r_[start:stop][::-1]
        pieces.append([np.r_[x[there], x[back], np.nan], np.r_[low[there], high[back], np.nan]])
    across, down = np.concatenate(pieces, axis=1)
    return Line(factor * across, scaled * down, f"{kind} band", "")


def against_frequency(trace: Trace, row: int, v: View) -> Safe | None:
    """Spectrum of the residual before and after."""
    if trace.t.size < 64:
        return None
    lines, densities = [], []
    factor, printed = scale(v.loudest or 1.0, unit_of(v, trace.channels[row]))
    for kind, r in _left(trace, row):
        f, d = spectrum(trace.t, r)
        lines.append(Line(f, factor * d, kind, kind))
        densities.append(factor * d[d > 0])
    every = np.concatenate(densities)
    if not every.size:
        return None
    high = float(every.max())
    low = max(float(every.min()), 1e-4 * high)
    low, high = (low, high) if high > 10 * low else (high / 10.0, high)
    x = Axis(float(lines[0].x[0]), float(lines[0].x[-1]), "frequency, Hz", log=True)
    y = Axis(low / 1.3, high * 1.3, f"measured − simulated, {printed}/√Hz", log=True)
    return plot(lines, x, y, "square", "against frequency")


def scan_panels(scan: ScanTrace, most: int = 12) -> list[Safe]:
    """Force against distance, one panel for each depth (evenly picked where there are more than `most`)."""
    picked = np.unique(np.linspace(0, scan.depth.size - 1, min(most, scan.depth.size)).round().astype(int))
    factor, name = scale(np.nanmax(np.abs(scan.measured), initial=0.0), "N")
    x = axis([1e3 * scan.distance], "distance from the taxel's centre, mm")
    return [_scan_panel(scan, i, x, factor, name) for i in picked]


def _scan_panel(scan: ScanTrace, i: int, x: Axis, factor: float, printed: str, height: str = "square") -> Safe:
    r = 1e3 * scan.distance
    lines = [Line(*_known(r, factor * curves[i]), kind, name) for kind, name, curves in simulations(scan)]
    lines.append(Line(*_known(r, factor * scan.measured[i]), "measured dots", "measured"))
    y = axis([line.y for line in lines], f"sensed force, {printed}", zero=True)
    return plot(lines, x, y, height, f"depth {amount(scan.depth[i], 'm')}")


def scan_picture(scan: ScanTrace) -> Safe:
    """Measured against simulated at the depth whose squared error fell most, above its residual."""
    before, after = (np.nansum((scan.measured - y) ** 2, axis=1) for y in (scan.baseline, scan.extended))
    i = int(np.argmax(before - after))
    x = axis([1e3 * scan.distance], "distance from the taxel's centre, mm")
    factor, printed = scale(np.nanmax(np.abs(scan.measured[i]), initial=0.0), "N")
    left = [(kind, scan.measured[i] - curves[i], _briefly(name)) for kind, name, curves in simulations(scan)]
    small, small_printed = scale(max(float(np.nanmax(np.abs(e), initial=0.0)) for _, e, _ in left), "N")
    below = [Line(*_known(1e3 * scan.distance, small * e), kind, name) for kind, e, name in left]
    y = axis([line.y for line in below], f"measured − simulated, {small_printed}", zero=True)
    return el("div", _scan_panel(scan, i, x, factor, printed, "tall bare"), plot(below, x, y, "low"))


def scan_left(scan: ScanTrace) -> list[Safe]:
    """The residual of a scan against distance (all depths), and its root mean square against depth."""
    left = [(kind, scan.measured - curves) for kind, _, curves in simulations(scan)]
    factor, printed = scale(max(float(np.nanmax(np.abs(e), initial=0.0)) for _, e in left), "N")
    r, d = 1e3 * scan.distance, 1e3 * scan.depth
    faint = [Line(*_known(r, factor * row), f"{kind} thin", kind) for kind, e in left for row in e]
    sizes = [Line(*_known(d, factor * np.sqrt(np.nanmean(e**2, axis=1))), kind, kind) for kind, e in left]
    x = axis([r], "distance from the taxel's centre, mm")
    y = axis([line.y for line in faint], f"measured − simulated, {printed}", zero=True)
    size = axis([line.y for line in sizes], f"typical error, {printed}", zero=True)
    return [
        plot(faint, x, y, "square", "against distance: a line per depth"),
        plot(sizes, axis([d], "depth, mm"), size, "square", "against depth"),
    ]


def _known(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    keep = np.isfinite(y)
    return x[keep], y[keep]
