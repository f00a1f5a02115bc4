"""The confusion matrix as a picture."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from skin_ident.hiding.tally import NOTHING, Result, confusion


def save_confusion(results: list[Result], path: Path) -> None:
    """Write the confusion matrix as a PNG: rows are what was hidden, columns what was named, shades the share of the row's cases."""
    causes, names, counts = confusion([r for r in results if "verdict" in r])
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    figure = Figure(figsize=(2.6 + 0.42 * len(names), 2.2 + 0.34 * len(causes)), layout="constrained")
    axes = figure.subplots()
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    axes.set_xticks(range(len(names)), [_words(n) for n in names], rotation=60, ha="right", rotation_mode="anchor")
    axes.set_yticks(range(len(causes)), [f"{_words(c)} ({n})" for c, n in zip(causes, counts.sum(axis=1), strict=True)])
    for i, j in zip(*np.nonzero(counts), strict=True):
        axes.text(j, i, str(counts[i, j]), ha="center", va="center", color="white" if share[i, j] > 0.55 else "black", fontsize=9)
    for i, j in ((i, names.index(c)) for i, c in enumerate(causes) if c in names):
        axes.add_patch(_frame(i, j))
    if "null" in causes:
        axes.add_patch(_frame(causes.index("null"), names.index(NOTHING)))
    axes.set_xlabel("named")
    axes.set_ylabel("hidden (cases)")
    axes.set_title("Hide and seek: framed is right", fontsize=10)
    figure.savefig(path, dpi=140)


def _words(name: str) -> str:
    return name.replace("_", " ")


def _frame(i: int, j: int) -> Rectangle:
    return Rectangle((j - 0.5, i - 0.5), 1, 1, fill=False, edgecolor="tab:orange", linewidth=1.5)
