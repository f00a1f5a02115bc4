"""One chart: lines in an SVG that stretches, ticks and labels as HTML that does not, so that text stays readable on a phone.

Points are whole numbers in a box of 2000 x 1000, written as relative moves: small, and exact to a fraction of a pixel.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from skin_ident.report.markup import Safe, el
from skin_ident.report.numbers import plain

WIDTH, HEIGHT = 2000, 1000


@dataclass(frozen=True)
class Axis:
    """An axis from `low` to `high` in printed units, logarithmic if `log`."""

    low: float
    high: float
    label: str
    log: bool = False

    def place(self, values: np.ndarray) -> np.ndarray:
        """Position of values (n,) along the axis, 0 to 1."""
        if self.log:
            a, b = math.log10(self.low), math.log10(self.high)
            return (np.log10(np.maximum(values, 1e-300)) - a) / (b - a)
        return (np.asarray(values, float) - self.low) / (self.high - self.low)


@dataclass(frozen=True)
class Line:
    """One curve: `kind` is its class in the style sheet (measured, before, after), with ` dashed`, ` dots` or ` band` added."""

    x: np.ndarray
    y: np.ndarray
    kind: str
    name: str


def axis(values: Sequence[np.ndarray], label: str, margin: float = 0.04, zero: bool = False) -> Axis:
    """An axis that holds all finite `values`, and zero if asked."""
    known = [v[np.isfinite(v)] for v in map(np.atleast_1d, values)]
    known = np.concatenate([np.zeros(1) if zero else np.zeros(0), *known])
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 1.0)
    if high - low < 1e-12:
        low, high = low - 0.5, high + 0.5
    extra = margin * (high - low)
    return Axis(low - extra, high + extra, label)


def plot(lines: Sequence[Line], x: Axis, y: Axis, height: str = "tall", title: str = "", live: bool = True) -> Safe:
    """The chart as a figure. `height` is a class of the style sheet (`bare`: no text below it); with `live` the pointer can read values."""
    zero = el("line", x1=0, x2=WIDTH, y1=_y0(y), y2=_y0(y), class_="zero") if not y.log and y.low < 0 < y.high else None
    x_ticks, y_ticks = ticks(x, 7), ticks(y, 5)
    grid = [el("line", x1=0, x2=WIDTH, y1=_down(y, v), y2=_down(y, v), class_="grid") for v, _ in y_ticks]
    curves = [_curve(line, x, y) for line in lines if line.x.size]
    svg = el(
        "svg", grid, zero, curves, viewBox=f"0 0 {WIDTH} {HEIGHT}", preserveAspectRatio="none", role="img", aria_label=title or y.label
    )
    marks_x = [el("i", text, style=f"left:{100 * float(x.place(v)):.2f}%") for v, text in x_ticks]
    marks_y = [el("i", text, style=f"bottom:{100 * float(y.place(v)):.2f}%") for v, text in y_ticks]
    data = {"data_x": f"{x.low:.6g} {x.high:.6g} {int(x.log)}", "data_y": f"{y.low:.6g} {y.high:.6g} {int(y.log)}"} if live else {}
    box = el(
        "div",
        el("div", svg, class_="area"),
        el("div", marks_x, class_="xt many" if len(marks_x) > 5 else "xt"),
        el("div", marks_y, class_="yt"),
        class_="box",
        **data,
    )
    return el(
        "figure",
        el("figcaption", title) if title else None,
        el("div", y.label, class_="yl"),
        box,
        el("div", x.label, class_="xl"),
        class_=f"plot {height}",
    )


def legend(*entries: tuple[str, str]) -> Safe:
    """The legend: a row of entries (kind, name)."""
    return el("div", [el("span", el("b", class_=f"key {kind}"), name) for kind, name in entries], class_="legend")


def ticks(a: Axis, most: int) -> list[tuple[float, str]]:
    """Round values on an axis, at most about `most`, with their text."""
    if a.log:
        decades = range(math.ceil(math.log10(a.low) - 1e-9), math.floor(math.log10(a.high) + 1e-9) + 1)
        if len(decades) < 3:
            every = [m * 10.0**d for d in range(math.floor(math.log10(a.low)), math.ceil(math.log10(a.high))) for m in (1, 2, 5)]
            return [(v, plain(v, 1)) for v in every if a.low <= v <= a.high]
        step = max(1, math.ceil(len(decades) / most))
        return [(10.0**d, plain(10.0**d, 1)) for d in list(decades)[::step]]
    step = _round_step((a.high - a.low) / most)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    first, last = math.ceil(a.low / step - 1e-9), math.floor(a.high / step + 1e-9)
    return [(i * step, _tick(i * step, decimals)) for i in range(first, last + 1)]


def _tick(value: float, decimals: int) -> str:
    return f"{value + 0.0:.{decimals}f}".replace("-", "−") if abs(value) < 1e6 and decimals < 5 else plain(value, 2)


def _round_step(rough: float) -> float:
    power = 10.0 ** math.floor(math.log10(rough))
    return next(m * power for m in (1.0, 2.0, 5.0, 10.0) if rough <= m * power * (1 + 1e-9))


def _down(y: Axis, value: float) -> int:
    return round(HEIGHT * (1.0 - float(y.place(value))))


def _y0(y: Axis) -> int:
    return _down(y, 0.0)


def _curve(line: Line, x: Axis, y: Axis) -> Safe:
    gaps = np.flatnonzero(~np.isfinite(line.y))
    pieces = [piece for piece in np.split(np.arange(line.y.size), gaps) if np.isfinite(line.y[piece]).any()]
    d = "".join(_piece(line, x, y, piece[np.isfinite(line.y[piece])]) for piece in pieces)
    return el("path", d=d, class_=line.kind, data_name=line.name)


def _piece(line: Line, x: Axis, y: Axis, piece: np.ndarray) -> str:
    """The part of a line between two gaps."""
    across = np.rint(WIDTH * x.place(line.x[piece])).astype(int)
    down = np.rint(HEIGHT * (1.0 - np.clip(y.place(line.y[piece]), -1.0, 2.0))).astype(int)
    if " dots" in line.kind:
        # A dot is a stroke of zero length with a round end, which stays round however the chart is stretched.
        return "".join(f"M{a} {b}h0" for a, b in zip(across, down, strict=True))
    return path(across, down) + ("z" if " band" in line.kind else "")


def path(across: np.ndarray, down: np.ndarray) -> str:
    """The SVG path through points with whole coordinates (n,), as relative moves."""
    steps = np.diff(np.stack([across, down], axis=1), axis=0)
    moves = " ".join(f"{a} {b}" for a, b in steps.tolist())
    return f"M{across[0]} {down[0]}" + (f"l{moves.replace(' -', '-')}" if moves else "")
