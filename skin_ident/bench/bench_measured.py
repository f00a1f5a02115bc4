"""What the diagnosis says of data that others measured: findings and their worth on held-out data, and the figures of doc/measured.md.

    bench_measured.py [FOLDER]        (./skin bench measured: as it stands)

Pictures go into FOLDER; left out: nothing is drawn. The data are not part of the suite: SKIN_MEASURED names their folder.
"""

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "test"))

from measured_layout import ABSENT, HERE, INSOLE, SCALE, WATER, fluid_rows, fluid_skin, insole, one_press, starts

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.recordings.chosen import only_taxels
from skin_ident.recordings.load import load
from skin_models.errors import SkinError

TAXELS = ("34", "74", "36")  # of the insole, among those that follow the pressure best


def sets(folder: Path):
    """Name, training and held-out recordings of everything that is diagnosed."""
    every = {name: load(fluid_skin(folder / "fluid") / f"{name}.csv")[0] for name in WATER}
    yield "walk of nine presses", [every["10mm"], every["30mm"]], [every["50mm"]]
    for number in (5, 7, 3, 9, 1):
        press = {name: load(one_press(folder / f"press_{number}", number) / f"{name}.csv")[0] for name in WATER}
        yield f"press {number} of 9", [press["10mm"], press["30mm"]], [press["50mm"]]
    soles = only_taxels(load([insole(folder / "insole") / f"{name}.csv" for name in INSOLE]), TAXELS)
    yield "insole, 3 taxels", soles[:1], soles[1:]
    yield from ((f"{name} alone", [r], []) for name, r in every.items())
    yield from ((f"{r.name} alone", [r], []) for r in soles)


def row(name: str, outcome: Outcome, seconds: float) -> str:
    """One line of the table."""
    f = outcome.findings
    named = "; ".join(_named(x) for x in f["findings"]) or "nothing"
    worth = ", ".join(
        f"{c} {g['held_out_rmse_before']:.3g} → {g['held_out_rmse_after']:.3g} (noise {g['noise_floor']:.2g})"
        for c, g in f["gain_by_channel"].items()
    )
    return f"| {name} | {named} | {worth} | {f['verdict']} | {seconds:.0f} |"


def _named(finding: dict) -> str:
    rivals = ", ".join(f"{a['cause']} {a['where']}" for a in finding["alternatives"])
    return f"{finding['cause']} {finding['where']}" + (f" (or {rivals})" if rivals else "")


def draw(folder: Path, outcomes: dict[str, Outcome]) -> None:
    """The figures."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(2, 2, figsize=(11, 6.4), layout="constrained")
    rows = fluid_rows("50mm")
    zero = np.median(rows[:100], axis=0)
    axes[0, 0].plot(rows[:, 0], -SCALE * (rows[:, 1] - zero[1]) / 25, color="#9aa0aa", label="force / 25, N")
    for c, name, colour in ((2, "left sensor, V", "#c8500a"), (3, "right sensor, V", "#0068b0")):
        axes[0, 0].plot(rows[:, 0], rows[:, c] - zero[c], color=colour, lw=1, label=name)
    axes[0, 0].set(title="fluid skin, 50 mm of water: as measured", xlabel="time, s")
    axes[0, 0].legend(fontsize=8)
    for name in WATER:
        rows, held = fluid_rows(name), []
        zero = np.median(rows[:100], axis=0)
        for i in starts(rows):
            force = -SCALE * np.median(rows[i + 120 : i + 190, 1] - zero[1])
            held.append([np.median(rows[i + 120 : i + 190, c] - zero[c]) / force for c in (2, 3)])
        axes[0, 1].plot(range(1, 10), np.array(held)[:, 0], "o-", color="#c8500a", lw=0.7, ms=3)
        axes[0, 1].plot(range(1, 10), np.array(held)[:, 1], "o-", color="#0068b0", lw=0.7, ms=3)
    axes[0, 1].set(title="slope of each sensor, press by press (four files)", xlabel="press", ylabel="V/N")
    _before_and_after(axes[1, 0], outcomes["walk of nine presses"], "taxel_1", "right sensor, the walk, held out", "V")
    _before_and_after(axes[1, 1], outcomes["insole, 3 taxels"], "taxel_0", "insole taxel 34, held out", "counts")
    for ax in axes.flat:
        ax.grid(alpha=0.25)
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / "measured.png", dpi=100)


def _before_and_after(ax, outcome: Outcome, channel: str, title: str, unit: str) -> None:
    trace = next(t for t in outcome.traces if t.held_out)
    i = trace.channels.index(channel)
    for y, colour, width, label in (
        (trace.measured, "#9aa0aa", 3, "measured"),
        (trace.baseline, "#c8500a", 1, "simulated before"),
        (trace.extended, "#0068b0", 1, "after"),
    ):
        ax.plot(trace.t, y[i], color=colour, lw=width, label=label)
    ax.set(title=title, xlabel="time, s", ylabel=unit)
    ax.legend(fontsize=8)


def main() -> None:
    """Print the table; draw the figures where a folder is named."""
    if HERE is None:
        print(f"left out: {ABSENT}")  # as the tests are: `./skin bench` goes on to the others
        return
    outcomes: dict[str, Outcome] = {}
    print("| data | named (or its rivals) | held-out error before → after | verdict | s |\n| --- | --- | --- | --- | --- |")
    with tempfile.TemporaryDirectory() as folder:
        for name, train, held in sets(Path(folder)):
            started = time.process_time()
            try:
                outcomes[name] = diagnose(train, held)
                print(row(name, outcomes[name], time.process_time() - started), flush=True)
            except SkinError as error:
                print(f"| {name} | refused: {error} | | | |", flush=True)
    if len(sys.argv) > 1:
        draw(Path(sys.argv[1]), outcomes)


if __name__ == "__main__":
    main()
