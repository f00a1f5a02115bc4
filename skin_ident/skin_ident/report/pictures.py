"""The pictures beside the report: measured against simulated before and after, the residual, and how the causes compare."""

from collections.abc import Callable

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from skin_ident.criticism.telling.outcome import Outcome, ScanTrace, Trace
from skin_ident.criticism.vocabulary import cause_at
from skin_ident.report.charts import below_band, goes_beyond, left_in_band, shown_range, simulations
from skin_ident.report.focus import Focus
from skin_ident.report.numbers import plain, scale
from skin_ident.report.shapes import residuals, spectrum, thinned
from skin_ident.report.story import Told, explaining, named_cause
from skin_ident.report.view import View, unit_of
from skin_ident.report.words import capital, channel, short
from skin_ident.stretches import runs

COLOURS = {"measured": "#9aa0aa", "before": "#c8500a", "after": "#0068b0"}
WIDTHS = {"measured": 4.0, "before": 1.3, "after": 1.3}
POINTS = 1500  # buckets of a curve (see `thinned`)
MOST_RANKED, MOST_ROUNDS = 6, 6  # causes of a round, and rounds, in the picture of the evidence


def pictures(told: Told) -> dict[str, Callable[[], Figure]]:
    """File names with the functions that draw them; `before_after.png` is the main picture. A picture without data is left out."""
    outcome, v, seen = told.outcome, told.view, told.seen
    drawn: dict[str, Callable[[], Figure]] = {}
    if seen is not None:
        drawn["before_after.png"] = lambda: _before_after(seen, v, _title(told, seen.trace.session))
        drawn["residual.png"] = lambda: _left(seen, v)
    elif outcome.scans:
        drawn["before_after.png"] = lambda: _scan(outcome.scans[0], _title(told, outcome.scans[0].session))
    if any(explaining(r, 1) for r in outcome.rounds):
        drawn["evidence.png"] = lambda: _evidence(outcome)
    return drawn


def save(figure: Figure, target) -> None:
    """Write a figure as PNG to `target`, a path or an open file."""
    FigureCanvasAgg(figure).print_png(target)


def _before_after(seen: Focus, v: View, title: str) -> Figure:
    """Measured against simulated above, the residual below; the most telling seconds on the left, the whole session on the right."""
    parts = [(seen.start, seen.stop)] if seen.is_whole else [(seen.start, seen.stop), (0, seen.trace.t.size)]
    figure = Figure(figsize=(6.5 * len(parts) + 0.5, 6.2), dpi=110, layout="constrained")
    axes = figure.subplots(2, len(parts), squeeze=False, sharex="col", sharey="row", gridspec_kw={"height_ratios": (2, 1)})
    unit = unit_of(v, seen.channel)
    for (start, stop), (top, below) in zip(parts, axes.T, strict=True):
        cut = slice(start, stop)
        _curves(seen, cut, v, top)
        _curves_left(seen, cut, v, below)
        for part in (top, below):
            _shaded(seen.trace, cut, part)
            _tidy(part)
        top.set_title("the whole session" if stop - start == seen.trace.t.size else seen.words, fontsize=10)
    if len(parts) == 2:
        axes[0, 1].set_title("the whole session (yellow: what is on the left)", fontsize=10)
        axes[0, 1].axvspan(seen.trace.t[seen.start], seen.trace.t[seen.stop - 1], ymin=0.97, color="#c9a400", zorder=0)
    y_unit = scale(np.nanmax(np.abs(seen.trace.measured[seen.row]), initial=0.0), unit)[1]
    axes[0, 0].set_ylabel(f"{channel(seen.channel)}, {y_unit}")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4, frameon=False, fontsize=9)
    figure.suptitle(title, fontsize=11)
    return figure


def _title(told: Told, session: str) -> str:
    better = told.story.better
    return f"{told.story.headline.title}\n{better.number} {better.caption} ({short(session, 60)})"


def _curves(seen: Focus, cut: slice, v: View, axes) -> None:
    """Draws measured and simulated curves, in a unit that suits the measurement."""
    t, unit = seen.trace.t[cut], unit_of(v, seen.channel)
    factor, _ = scale(np.nanmax(np.abs(seen.trace.measured[seen.row]), initial=0.0), unit)
    drawn = (("measured", "measured", seen.trace.measured), *reversed(simulations(seen.trace)))
    for order, (kind, label, curves) in enumerate(drawn):
        style = (0, (5, 4)) if kind == "before" else "-"  # dashed and on top, so that both simulations can be seen where they agree
        line = thinned(t, factor * curves[seen.row][cut], POINTS)
        axes.plot(*line, color=COLOURS[kind], lw=WIDTHS[kind], ls=style, label=label, zorder=2 + order)


def _curves_left(seen: Focus, cut: slice, v: View, below) -> None:
    """Draws the residuals in the band in which errors are counted, on an axis that suits the whole session."""
    small, name = _small(seen, unit_of(v, seen.channel), v)
    left = left_in_band(seen.trace, seen.row, v, slice(None))
    for kind, _, r in left:
        below.plot(*thinned(seen.trace.t[cut], small * r[cut], POINTS), color=COLOURS[kind], lw=1.0)
    low, high = shown_range(left, seen.trace.compared)
    margin = small * max(0.05 * (high - low), 1e-12)
    below.set_ylim(small * low - margin, small * high + margin)
    below.set_xlabel("time, s")
    if below.get_subplotspec().is_first_col():
        cut_at = "\n(axis cut)" if goes_beyond(left, seen.trace.compared) else ""
        below.set_ylabel(f"measured −\nsimulated, {name}" + below_band(v).replace(" below", "\nbelow") + cut_at)


def _shaded(trace: Trace, cut: slice, axes) -> None:
    """Shades the stretches that were not compared."""
    t = trace.t[cut]
    for i, (a, b) in enumerate(zip(*runs(~trace.compared[cut]), strict=True)):
        axes.axvspan(t[a], t[min(b, t.size - 1)], color="#e3e5e9", lw=0, zorder=0, label="" if i else "not compared")


def _small(seen: Focus, unit: str, v: View) -> tuple[float, str]:
    """Factor and unit for residuals: those of all errors on the page, or, without any, what suits the residuals."""
    return scale(v.loudest or max(float(np.nanmax(np.abs(r), initial=0.0)) for r in residuals(seen.trace, seen.row)), unit)


def _tidy(axes) -> None:
    axes.set_axisbelow(True)
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
    figure = Figure(figsize=(4.2 * (len(moving) + 1), 3.9), dpi=110, layout="constrained")
    axes = figure.subplots(1, len(moving) + 1, squeeze=False)[0]
    small, name = _small(seen, unit, v)
    every = max(1, trace.t.size // 6000)
    told = trace.compared & ~(np.nan_to_num(trace.depth) < 0.0) if trace.depth is not None else trace.compared  # in contact
    for kind, label, curves in simulations(trace):
        left = trace.measured[seen.row] - curves[seen.row]
        for ax, (quantity, _) in zip(axes, moving, strict=False):
            ax.plot(1e3 * quantity[told][::every], small * left[told][::every], ".", ms=1.5, alpha=0.5, color=COLOURS[kind])
        if trace.t.size >= 64:
            f, density = spectrum(trace.t, left)
            axes[-1].loglog(f, small * density, color=COLOURS[kind], lw=1.3)
        axes[0].plot([], [], color=COLOURS[kind], lw=2.0, label=label.replace("simulated", "what is left").strip())
    for ax, (_, label) in zip(axes, moving, strict=False):
        ax.set(xlabel=label, ylabel=f"measured − simulated, {name}")
    axes[-1].set(xlabel="frequency, Hz", ylabel=f"measured − simulated, {name}/√Hz")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, frameon=False, fontsize=9)
    for ax in axes:
        _tidy(ax)
    figure.suptitle(f"What is left in {channel(seen.channel)}", fontsize=11)
    return figure


def _scan(scan: ScanTrace, title: str) -> Figure:
    """Force over distance at up to four depths above, the residual below."""
    picked = np.unique(np.linspace(0, scan.depth.size - 1, min(4, scan.depth.size)).round().astype(int))
    figure = Figure(figsize=(3.4 * picked.size + 0.5, 5.8), dpi=110, layout="constrained")
    axes = figure.subplots(2, picked.size, squeeze=False, sharex=True, sharey="row", gridspec_kw={"height_ratios": (2, 1)})
    r = 1e3 * scan.distance
    for i, (top, below) in zip(picked, axes.T, strict=True):
        for kind, label, curves in simulations(scan):
            top.plot(r, curves[i], color=COLOURS[kind], label=label)
            below.plot(r, scan.measured[i] - curves[i], ".-", color=COLOURS[kind])
        top.plot(r, scan.measured[i], "o", color="#2b2e35", ms=5, label="measured")
        top.set_title(f"depth {1e3 * scan.depth[i]:.3g} mm", fontsize=10)
        below.set_xlabel("distance, mm")
        _tidy(top), _tidy(below)
    axes[0, 0].set_ylabel("sensed force, N")
    axes[1, 0].set_ylabel("measured −\nsimulated, N")
    axes[0, -1].legend(fontsize=8)
    figure.suptitle(title, fontsize=11)
    return figure


def _evidence(outcome: Outcome) -> Figure:
    """The ranking of every round in which some cause explains something, each to its own scale, the named cause in blue."""
    rounds = [(i, r.named, best) for i, r in enumerate(outcome.rounds, 1) if (best := explaining(r, MOST_RANKED))][:MOST_ROUNDS]
    heights = [len(best) + 2 for _, _, best in rounds]
    figure = Figure(figsize=(8.5, 0.6 + 0.35 * len(rounds) + 0.25 * sum(heights)), dpi=110, layout="constrained")
    axes = figure.subplots(len(rounds), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    for ax, (number, named, best) in zip(axes, rounds, strict=True):
        chosen = next((i for i, (cause, _, _) in enumerate(best) if named and cause == named_cause(named)), None)
        colours = [COLOURS["after" if i == chosen else "measured"] for i in range(len(best))]
        labels = [short(capital(cause_at(c, w))) for c, w, _ in best]
        bars = ax.barh(range(len(best)), [g for _, _, g in best], color=colours, height=0.7)
        ax.bar_label(bars, [plain(g) for _, _, g in best], padding=3, fontsize=8)
        ax.set_yticks(range(len(best)), labels, fontsize=8)
        ax.invert_yaxis()
        ax.set_title(f"round {number}: what each cause alone would explain, as estimated when it began", fontsize=9, loc="left")
        ax.tick_params(labelsize=8)
        ax.xaxis.set_major_locator(MaxNLocator(6))
        _tidy(ax)
        ax.margins(x=0.1)  # for the numbers at the bars
    axes[-1].set_xlabel("fall of the squared error, in units of the variance of the noise (each round to its own scale)", fontsize=8)
    return figure
