"""The picture, drawn with matplotlib."""

import io

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot as plt

from skin_models.acuity.patch import Patch, looked_at
from skin_models.design import acuity

PITCHES = np.linspace(0.75, 3.2, 25)  # in widths of the spread


def png(patch: Patch) -> bytes:
    """Three panels: error against the pitch of a grid, error over this patch, smallest force over this patch."""
    with plt.rc_context({"font.size": 9.0, "axes.spines.top": False, "axes.spines.right": False}):
        figure, axes = plt.subplots(1, 3, figsize=(13.5, 4.3), layout="constrained")
        figure.suptitle(f"{patch.name}, {patch.force:g} N, noise {1e3 * patch.noise:.3g} mN", fontsize=10)
        _against_pitch(axes[0], patch)
        over = looked_at(patch)
        _map(figure, axes[1], patch, over.x, over.y, 1e3 * over.error, "error of the position, mm")
        _map(figure, axes[2], patch, over.x, over.y, over.force, "smallest force that is told, N")
        out = io.BytesIO()
        figure.savefig(out, format="png", dpi=110)
        plt.close(figure)
    return out.getvalue()


def _against_pitch(axis, patch: Patch) -> None:
    rows = acuity(patch.kernel.width, PITCHES * patch.kernel.width, patch.force, patch.noise, patch.share)
    mm = [1e3 * a.pitch for a in rows]
    axis.semilogy(mm, mm, ":", color="#6b7280", label="the pitch itself")
    axis.semilogy(mm, [1e3 * a.error_worst for a in rows], color="#c4391d", label="worst place")
    axis.semilogy(mm, [1e3 * a.error_median for a in rows], color="#1f5fa8", label="median place")
    if mm[0] <= 1e3 * patch.layout.pitch <= mm[-1]:
        axis.axvline(1e3 * patch.layout.pitch, color="#9aa3ad", linewidth=0.8, label="pitch of this patch")
    best = min(a.error_median for a in rows)
    axis.set(xlabel="pitch of a square grid, mm", ylabel="error of the position, mm", xlim=(mm[0], mm[-1]))
    axis.set_ylim(3e2 * best, 3e1 * mm[-1])
    axis.set_title("a wide grid, away from its edges", fontsize=9)
    axis.legend(frameon=False, fontsize=8)


def _map(figure, axis, patch: Patch, x: np.ndarray, y: np.ndarray, values: np.ndarray, label: str) -> None:
    """Colours over the patch on a logarithmic scale; white where it cannot be told."""
    axis.plot(*(1e3 * patch.layout.positions[:, :2].T), "o", color="white", markeredgecolor="#374151", markersize=5, clip_on=False)
    axis.set(xlabel="x, mm", ylabel="y, mm", aspect="equal")
    axis.margins(0.04)
    axis.set_title(label, fontsize=9)
    shown = np.ma.masked_invalid(values)
    if shown.count() == 0:
        axis.text(0.5, 0.5, "cannot be told", transform=axis.transAxes, ha="center", va="center", bbox={"color": "white"})
        return
    low, high = float(shown.min()), float(np.quantile(shown.compressed(), 0.98))
    norm = matplotlib.colors.LogNorm(low, max(high, 1.05 * low))
    shading = "nearest" if np.ma.is_masked(shown) else "gouraud"
    image = axis.pcolormesh(1e3 * x, 1e3 * y, shown, norm=norm, cmap="viridis", shading=shading, zorder=0)
    bar = figure.colorbar(image, ax=axis, shrink=0.85, extend="max")
    bar.ax.yaxis.set_major_locator(matplotlib.ticker.LogLocator(subs=_marks(norm.vmax / norm.vmin), numticks=20))
    bar.ax.yaxis.set_minor_locator(matplotlib.ticker.NullLocator())
    bar.ax.yaxis.set_major_formatter(matplotlib.ticker.FuncFormatter(lambda v, _: f"{v:.3g}"))


def _marks(ratio: float) -> tuple[float, ...]:
    """Which multiples of a power of ten are marked on a scale from 1 to `ratio`, so that a few are and none overlap."""
    return (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0) if ratio < 8.0 else (1.0, 2.0, 5.0) if ratio < 300.0 else (1.0,)
