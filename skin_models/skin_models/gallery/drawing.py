"""Pictures drawn with matplotlib, as PNG."""

import io

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from skin_models.gallery.scene import Picture

WITHOUT, WITH, CHANGE = "#9aa3ad", "#c4391d", "#1f5fa8"
STYLE = {
    "font.size": 8.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#6b7280",
    "axes.labelcolor": "#374151",
    "xtick.color": "#6b7280",
    "ytick.color": "#6b7280",
    "axes.grid": True,
    "grid.color": "#eceff3",
    "axes.axisbelow": True,
}


def png(p: Picture) -> bytes:
    """Three panels: the trace, force against depth (or the spread over the distance), and the difference; the effect is in red."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 3, figsize=(10.6, 2.5), width_ratios=(1.55, 1.0, 1.0), layout="constrained")
        _trace(axes[0], p)
        (_loop if p.profile is None else _profile)(axes[1], p)
        _difference(axes[2], p)
        out = io.BytesIO()
        figure.savefig(out, format="png", dpi=110)
        plt.close(figure)
    return out.getvalue()


def overview(shown: list[Picture], columns: int = 5) -> bytes:
    """All effects on one sheet: traces, or the difference where the traces look alike."""
    rows = -(-len(shown) // columns)
    with plt.rc_context({**STYLE, "font.size": 7.0}):
        figure, axes = plt.subplots(rows, columns, figsize=(2.9 * columns, 1.75 * rows), layout="constrained", squeeze=False)
        for axis, p in zip(axes.flat, shown, strict=False):
            (_difference if p.faint else _trace)(axis, p, labelled=False)
            axis.set_title(title(p), fontsize=7.5, loc="left", color="#111827")
            axis.set_xlabel("time (s)", labelpad=1)
            axis.set_ylabel("difference (N)" if p.faint else "force (N)", labelpad=1)
        for axis in axes.flat[len(shown) :]:
            axis.set_axis_off()
        out = io.BytesIO()
        figure.savefig(out, format="png", dpi=110)
        plt.close(figure)
    return out.getvalue()


def title(p: Picture) -> str:
    """Cause, form and place."""
    form = f" ({p.effect.form})" if p.effect.form else ""
    return f"{p.effect.cause}{form} · {p.effect.where}"


def _trace(axis, p: Picture, labelled: bool = True) -> None:
    axis.plot(p.t[p.seen], p.without[p.seen], color=WITHOUT, linewidth=1.6, label="without")
    axis.plot(p.t[p.seen], p.with_it[p.seen], color=WITH, linewidth=0.9, label="with")
    if labelled:
        axis.set_xlabel("time (s)")
        axis.set_ylabel(f"{p.channel} (N)")
        axis.legend(frameon=False, fontsize=8)


def _loop(axis, p: Picture) -> None:
    axis.plot(1e3 * p.depth, p.without, color=WITHOUT, linewidth=1.4)
    axis.plot(1e3 * p.depth, p.with_it, color=WITH, linewidth=0.8)
    axis.set_xlim(-0.6, 1.8)
    axis.set_xlabel("encoder depth (mm)")
    axis.set_ylabel("force (N)")


def _profile(axis, p: Picture) -> None:
    x, without, with_it = p.profile
    axis.plot(1e3 * x, without, color=WITHOUT, linewidth=1.6)
    axis.plot(1e3 * x, with_it, color=WITH, linewidth=0.9)
    axis.set_xlabel("from the place declared, along x (mm)")
    axis.set_ylabel("share, 1 mm deep")


def _difference(axis, p: Picture, labelled: bool = True) -> None:
    change = (p.with_it - p.without)[p.seen]
    axis.plot(p.t[p.seen], change, color=CHANGE, linewidth=0.9)
    axis.axhline(0.0, color="#6b7280", linewidth=0.6)
    if labelled:
        axis.set_xlabel("time (s)")
        axis.set_ylabel("with − without (N)")
    if np.ptp(change) < 1e-9:
        axis.set_ylim(-1.0, 1.0)
