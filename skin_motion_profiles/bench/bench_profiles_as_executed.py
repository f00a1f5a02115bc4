"""Every profile as the simulated rig executes it, beside what was planned: a table, and a page of plots with --picture FILE.

The deviation holds everything between plan and encoder: streaming, splicing, interpolation, the stage's screw and rest errors (2.5 and
5 um) and its encoder's step (1 um). What a user would do instead stands beside it: the set points as steps, one every 10 ms, as a loop
that publishes positions without speeds would send them (computed, not executed).
"""

import argparse
from pathlib import Path

import numpy as np
from session import Session, seconds

from skin_motion_profiles.entry import Entry
from skin_motion_profiles.picture import gallery
from skin_motion_profiles.plan import Motion, Travel, stages
from skin_motion_profiles.profile_file import entry_to_text

TRAVEL = Travel(0.002, 0.05)  # the server's own
SHORT = {"lateral_scan", "battery"}  # several stages: not one function of time


def planned(entry: Entry, start: float) -> Motion:
    """What the server makes of an entry from depth `start` (m)."""
    return stages(entry)[0].motion(start, TRAVEL)


def where(session: Session, told: float | None) -> float:
    """Where the server begins: where it told the driver to rest, if the encoder agrees."""
    depth = session.encoder[-1][1]
    return told if told is not None and abs(told - depth) < 2e-5 else depth


def as_executed(session: Session, entry: Entry, told: float | None) -> tuple[tuple[np.ndarray, ...], float]:
    """Times (s) from the first moment of motion, depths of the encoder and of the plan (m); and the depth where the plan ends."""
    start = where(session, told)
    result, encoder, _ = session.execute(entry_to_text(entry))
    if result.error_code != 0:
        raise SystemExit(f"{entry.label}: {result.error_string}")
    motion = planned(entry, start).trajectory
    t = encoder[:, 0] - seconds(result.started)
    within = (t >= 0.0) & (t <= motion.duration)
    return (t[within], encoder[within, 1], motion.sample(t[within]).x), motion.end


def steps_error(motion_x: np.ndarray) -> float:
    """Greatest error of set points sent as steps every sample: the way of one sample."""
    return float(np.abs(np.diff(motion_x)).max())


def draw(runs: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]], path: Path) -> None:
    """Plan and encoder in mm, their difference in um below."""
    from matplotlib.figure import Figure

    rows = -(-len(runs) // 3)
    figure = Figure(figsize=(16, 3.6 * rows), layout="constrained")
    grids = figure.subfigures(rows, 3).ravel()
    for grid, (name, (t, measured, plan)) in zip(grids, runs.items(), strict=False):
        upper, lower = grid.subplots(2, 1, sharex=True, height_ratios=[3, 1])
        upper.plot(t, plan * 1e3, color="#c9662f", lw=2.5, alpha=0.5, label="planned")
        upper.plot(t, measured * 1e3, color="#0b5c8a", lw=0.9, label="encoder")
        upper.invert_yaxis()
        upper.set(ylabel="depth / mm")
        upper.set_title(name, fontsize=9, loc="left")
        upper.legend(fontsize=7, loc="upper right")
        lower.plot(t, (measured - plan) * 1e6, color="#555555", lw=0.7)
        lower.set(xlabel="time / s", ylabel="error / um")
    figure.savefig(path, dpi=90)


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    runs, told = {}, None
    print(f"{'profile':22s} {'time':>7s} {'samples':>8s} {'rms':>8s} {'max':>8s} {'as steps':>9s} {'ratio':>7s}")
    with Session() as session:
        for name, entry in gallery().items():
            if name in SHORT:
                continue
            (t, measured, plan), told = as_executed(session, entry, told)
            runs[name] = t, measured, plan
            error = np.abs(measured - plan)
            steps = steps_error(plan)
            print(
                f"{name:22s} {t[-1]:5.1f} s {t.size:8d} {np.sqrt(np.mean(error**2)) * 1e6:5.1f} um {error.max() * 1e6:5.1f} um "
                f"{steps * 1e6:6.0f} um {steps / error.max() if steps else float('nan'):7.1f}"
            )
        cpu, wall = session.server_cpu(), sum(t[-1] for t, _, _ in runs.values())
        print(f"the server used {cpu:.1f} s of processor for {wall:.0f} s of motion ({cpu / wall:.0%}), with its start")
    if options.picture:
        draw(runs, options.picture)


if __name__ == "__main__":
    main()
