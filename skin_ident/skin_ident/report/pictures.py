"""The pictures beside the report: measured against simulated before and after, what is left, and how the causes compare."""

from collections.abc import Callable

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from skin_ident.criticism.outcome import Outcome, ScanTrace
from skin_ident.report.focus import Focus, focus
from skin_ident.report.numbers import scale
from skin_ident.report.shapes import residuals, spectrum, thinned
from skin_ident.report.story import story, unit_of
from skin_ident.report.view import View, view
from skin_ident.report.words import capital, cause_at, channel

COLOURS = {"measured": "#9aa0aa", "before": "#c8500a", "after": "#0068b0"}
WIDTHS = {"measured": 3.2, "before": 1.3, "after": 1.3}
NAMES = {"measured": "measured", "before": "simulated before", "after": "simulated after"}
POINTS = 1500


def pictures(outcome: Outcome) -> dict[str, Callable[[], Figure]]:
    """File name to the function that draws it; `before_after.png` is the one picture. Empty without any curves."""
    v = view(outcome.findings)
    seen = focus(outcome.traces, v)
    drawn: dict[str, Callable[[], Figure]] = {}
    if seen is not None:
        drawn["before_after.png"] = lambda: _before_after(seen, v, outcome)
        drawn["residual.png"] = lambda: _left(seen, v)
    elif outcome.scans:
        drawn["before_after.png"] = lambda: _scan(outcome.scans[0], outcome)
    if any(r.ranked for r in outcome.rounds):
        drawn["evidence.png"] = lambda: _evidence(outcome)
    return drawn


def save(figure: Figure, target) -> None:
    """Write a figure as PNG to an open file."""
    FigureCanvasAgg(figure).print_png(target)


def _before_after(seen: Focus, v: View, outcome: Outcome) -> Figure:
    """Measured against simulated above, the residual below; left the most telling seconds, right the whole session."""
    parts = [(seen.start, seen.stop)] if seen.is_whole else [(seen.start, seen.stop), (0, seen.trace.t.size)]
    figure = Figure(figsize=(6.5 * len(parts) + 0.5, 6.2), dpi=110, layout="constrained")
    axes = figure.subplots(2, len(parts), squeeze=False, sharex="col", sharey="row", gridspec_kw={"height_ratios": (2, 1)})
    unit = unit_of(v, seen.channel)
    for (start, stop), (top, below) in zip(parts, axes.T, strict=True):
        _curves(seen, slice(start, stop), unit, top, below)
        top.set_title("whole session" if stop - start == seen.trace.t.size else "the most telling seconds", fontsize=10)
    if len(parts) == 2:
        axes[0, 1].axvspan(seen.trace.t[seen.start], seen.trace.t[seen.stop - 1], color="#f0e6c0", zorder=0)
    y_unit = scale(np.nanmax(np.abs(seen.trace.measured[seen.row]), initial=0.0), unit)[1]
    axes[0, 0].set_ylabel(f"{channel(seen.channel)}, {y_unit}")
    axes[0, 0].legend(loc="upper right", fontsize=8, framealpha=0.85)
    figure.suptitle(_title(outcome, v, seen.trace.session, seen.trace.held_out), fontsize=11)
    return figure


def _title(outcome: Outcome, v: View, session: str, held_out: bool | None) -> str:
    told = story(outcome, v)
    role = {True: " (not used for fitting)", False: " (used for fitting)", None: ""}[held_out]
    return f"{told.headline.title}\n{session[:70]}{role}: {told.better.number} {told.better.caption}"


def _curves(seen: Focus, cut: slice, unit: str, top, below) -> None:
    t = seen.trace.t[cut]
    rows = {"measured": seen.trace.measured, "before": seen.trace.baseline, "after": seen.trace.extended}
    factor, _ = scale(np.nanmax(np.abs(seen.trace.measured[seen.row]), initial=0.0), unit)
    for kind, y in rows.items():
        top.plot(*thinned(t, factor * y[seen.row][cut], POINTS), color=COLOURS[kind], lw=WIDTHS[kind], label=NAMES[kind])
    pair = residuals(seen.trace, seen.row)
    small, name = scale(max(float(np.nanmax(np.abs(r), initial=0.0)) for r in pair), unit)
    for kind, r in zip(("before", "after"), pair, strict=True):
        below.plot(*thinned(t, small * r[cut], POINTS), color=COLOURS[kind], lw=1.0)
    below.set_xlabel("time, s")
    if below.get_subplotspec().is_first_col():
        below.set_ylabel(f"measured − simulated, {name}")
    for axes in (top, below):
        _tidy(axes)


def _tidy(axes) -> None:
    axes.grid(color="#e5e7ea", lw=0.8)
    axes.spines[["top", "right"]].set_visible(False)
    axes.margins(x=0.01)


def _left(seen: Focus, v: View) -> Figure:
    """The residual against depth, speed and frequency."""
    unit = unit_of(v, seen.channel)
    trace = seen.trace
    moving = [
        (q, label) for q, label in ((trace.depth, "depth, mm"), (trace.speed, "speed, mm/s")) if q is not None and np.isfinite(q).any()
    ]
    figure = Figure(figsize=(4.2 * (len(moving) + 1), 3.6), dpi=110, layout="constrained")
    axes = figure.subplots(1, len(moving) + 1, squeeze=False)[0]
    pair = residuals(trace, seen.row)
    small, name = scale(max(float(np.nanmax(np.abs(r), initial=0.0)) for r in pair), unit)
    every = max(1, trace.t.size // 6000)
    for ax, (quantity, label) in zip(axes, moving, strict=False):
        for r, kind in zip(pair, ("before", "after"), strict=True):
            ax.plot(1e3 * quantity[::every], small * r[::every], ".", ms=1.5, alpha=0.5, color=COLOURS[kind], label=kind)
        ax.set_xlabel(label)
        ax.set_ylabel(f"measured − simulated, {name}")
    for r, kind in zip(pair, ("before", "after"), strict=True):
        if trace.t.size >= 64:
            axes[-1].loglog(*spectrum(trace.t, r), color=COLOURS[kind], lw=1.3, label=kind)
    axes[-1].set(xlabel="frequency, Hz", ylabel=f"measured − simulated, {unit}/√Hz")
    axes[-1].legend(fontsize=8)
    for ax in axes:
        _tidy(ax)
    figure.suptitle(f"What is left in {channel(seen.channel)}", fontsize=11)
    return figure


def _scan(scan: ScanTrace, outcome: Outcome) -> Figure:
    """Force over distance at four depths above, what is left below."""
    picked = np.unique(np.linspace(0, scan.depth.size - 1, min(4, scan.depth.size)).round().astype(int))
    figure = Figure(figsize=(3.4 * picked.size + 0.5, 5.8), dpi=110, layout="constrained")
    axes = figure.subplots(2, picked.size, squeeze=False, sharex=True, sharey="row", gridspec_kw={"height_ratios": (2, 1)})
    r = 1e3 * scan.distance
    for i, (top, below) in zip(picked, axes.T, strict=True):
        top.plot(r, scan.baseline[i], color=COLOURS["before"], label="simulated before")
        top.plot(r, scan.extended[i], color=COLOURS["after"], label="simulated after")
        top.plot(r, scan.measured[i], "o", color="#2b2e35", ms=5, label="measured")
        top.set_title(f"depth {1e3 * scan.depth[i]:.3g} mm", fontsize=10)
        for y, kind in ((scan.baseline, "before"), (scan.extended, "after")):
            below.plot(r, scan.measured[i] - y[i], ".-", color=COLOURS[kind])
        below.set_xlabel("distance, mm")
        _tidy(top), _tidy(below)
    axes[0, 0].set_ylabel("sensed force, N")
    axes[1, 0].set_ylabel("measured − simulated, N")
    axes[0, -1].legend(fontsize=8)
    figure.suptitle(_title(outcome, view(outcome.findings), scan.session, None), fontsize=11)
    return figure


def _evidence(outcome: Outcome) -> Figure:
    """The ranking of every round, the named cause in blue."""
    rounds = [r for r in outcome.rounds if r.ranked][:6]
    figure = Figure(figsize=(8.5, 0.6 + 2.2 * len(rounds)), dpi=110, layout="constrained")
    for ax, (number, round_) in zip(figure.subplots(len(rounds), 1, squeeze=False)[:, 0], enumerate(rounds, 1), strict=True):
        best = sorted(round_.ranked, key=lambda r: -r[2])[:6][::-1]
        named = (round_.named or "").split(" ")[0].split(".")[0]
        colours = [COLOURS["after"] if cause == named else COLOURS["measured"] for cause, _, _ in best]
        ax.barh([capital(cause_at(c, w))[:48] for c, w, _ in best], [max(g, 0.0) for _, _, g in best], color=colours)
        ax.set_title(f"round {number}: what each cause alone explains (squared error in units of the noise)", fontsize=9, loc="left")
        ax.tick_params(labelsize=8)
        _tidy(ax)
    return figure
