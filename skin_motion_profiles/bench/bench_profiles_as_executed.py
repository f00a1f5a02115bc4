"""Every profile as the simulated rig executes it, beside what was planned: a table, and a page of plots with --picture FILE.

Motions stand beside their plan; force control beside its target; what is more than one motion (a scan, a battery, zero and tare) with
what goes with it.

The deviation holds everything between plan and encoder: streaming, splicing, interpolation, the stage's screw and rest errors (2.5 and
5 um) and its encoder's step (1 um). What a user would do instead stands beside it: the set points as steps, one every 10 ms, as a loop
that publishes positions without speeds would send them (computed, not executed).
"""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from session import Session, seconds

from skin_motion_profiles.catalogue import entries, entry_from_dict
from skin_motion_profiles.control import Controlled
from skin_motion_profiles.entry import Entry
from skin_motion_profiles.plan import Motion, Travel, stages
from skin_motion_profiles.profile_file import entry_to_text

TRAVEL = Travel(0.002, 0.05)  # the server's own
ORDER = (
    "straight_line", "step", "repeated_step", "stair_step", "ramp_list", "random_ramps", "sine", "multisine", "constant_strain_hold",
    "constant_rate_loops", "minor_loops", "hold", "free_air", "lateral_scan", "incremental_force", "explicit_force", "prepare", "battery",
)  # fmt: skip
STAGED = {"lateral_scan", "battery", "prepare"}  # several stages: not one function of time


@dataclass(frozen=True)
class Panel:
    """Two plots over the same time (s): each of a label, what was measured, and what was planned or None. `note` is the title."""

    t: np.ndarray
    upper: tuple[str, np.ndarray, np.ndarray | None]
    lower: tuple[str, np.ndarray, np.ndarray | None]
    note: str


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


def example(name: str) -> Entry:
    """The catalogue's example of a profile, and one battery."""
    if name == "prepare":
        return entry_from_dict({"battery": "prepare"})
    return entry_from_dict({"type": name, **entries()[name].example})


def in_stages(session: Session, entry: Entry, name: str) -> Panel:
    """A scan with the place of its stage, a battery with its force."""
    session.place.clear()
    result, encoder, force = session.execute(entry_to_text(entry))
    if result.error_code != 0:
        raise SystemExit(f"{name}: {result.error_string}")
    begin = seconds(result.started)
    t = encoder[:, 0] - begin
    if name == "lateral_scan":
        place = np.array(session.place)
        below = "x / mm", 1e3 * np.interp(t, place[:, 0] - begin, place[:, 1]), None
    else:
        below = "force / N", np.interp(t, force[:, 0] - begin, force[:, 1]), None
    return Panel(t, ("depth / mm", 1e3 * encoder[:, 1], None), below, f"{name}, {t[-1]:.0f} s")


def controlled(session: Session, entry: Controlled, name: str) -> Panel:
    """The force beside its target, from contact on."""
    session.execute("{type: straight_line, to_mm: -0.05, speed_mm_s: 2}")
    result, encoder, force = session.execute(entry_to_text(entry))
    if result.error_code != 0:
        raise SystemExit(f"{name}: {result.error_string}")
    contact = force[np.argmax(force[:, 1] >= entry.contact_n), 0]
    t = force[:, 0] - contact
    depth = np.interp(force[:, 0], encoder[:, 0], 1e3 * encoder[:, 1])
    within = (t > -1.0) & (t < entry.duration)
    target = np.array([entry.target(max(s, 0.0))[0] if s >= 0.0 else 0.0 for s in t[within]])
    off = force[within, 1] - target
    late = t[within] > 1.0
    print(f"{name:22s} {t[within][-1]:5.1f} s {late.sum():8d} {np.sqrt(np.mean(off[late] ** 2)):5.2f} N  {np.abs(off[late]).max():5.2f} N")
    return Panel(t[within], ("force / N", force[within, 1], target), ("depth / mm", depth[within], None), f"{name}, from contact")


def motion(session: Session, entry: Entry, name: str, told: float | None) -> tuple[Panel, float, float]:
    """A motion beside its plan; where it ends, and how long it took."""
    (t, measured, plan), told = as_executed(session, entry, told)
    error, steps = np.abs(measured - plan), steps_error(plan)
    print(
        f"{name:22s} {t[-1]:5.1f} s {t.size:8d} {np.sqrt(np.mean(error**2)) * 1e6:5.1f} um {error.max() * 1e6:5.1f} um "
        f"{steps * 1e6:6.0f} um {f'{steps / error.max():.1f}' if steps else '-':>7s}"
    )
    off = 1e6 * (measured - plan)
    title = f"{name}, off by {np.abs(off).max():.1f} um at most"
    return Panel(t, ("depth / mm", 1e3 * measured, 1e3 * plan), ("off / um", off, None), title), told, t[-1]


def draw(panels: list[Panel], path: Path) -> None:
    """All panels on one page."""
    from matplotlib.figure import Figure

    rows = -(-len(panels) // 3)
    figure = Figure(figsize=(15, 2.9 * rows), layout="constrained")
    for grid, panel in zip(figure.subfigures(rows, 3).ravel(), panels, strict=False):
        axes = grid.subplots(2, 1, sharex=True, height_ratios=[2.4, 1])
        for ax, (label, measured, plan) in zip(axes, (panel.upper, panel.lower), strict=True):
            if plan is not None:
                ax.plot(panel.t, plan, color="#e39a6b", lw=3.5, solid_capstyle="butt", label="planned")
            ax.plot(panel.t, measured, color="#0b5c8a", lw=0.9, label="measured")
            ax.set_ylabel(label, fontsize=8)
            ax.tick_params(labelsize=7)
            ax.grid(lw=0.3)
            ax.set_ylim(*span(label, measured))
        axes[0].set_title(panel.note, fontsize=9, loc="left")
        axes[1].set_xlabel("time / s", fontsize=8)
        grid.align_ylabels(axes)
    handles, labels = figure.subfigs[0].axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2, fontsize=9)
    figure.savefig(path, dpi=100)


def span(label: str, values: np.ndarray) -> tuple[float, float]:
    """What an axis shows: down is into the skin, a rest is no mountain range, and errors compare from panel to panel."""
    if label == "off / um":
        return -6.5, 6.5
    low, high = float(values.min()), float(values.max())
    room = max(0.06 * (high - low), 0.05)
    return (high + room, low - room) if label.startswith("depth") else (low - room, high + room)


def panel_of(session: Session, name: str, told: float | None) -> tuple[Panel, float | None, float]:
    """One profile: its panel, where the plunger was told to rest (None: nobody knows), and s of plain motion."""
    entry: Any = example(name)
    if name in STAGED:
        return in_stages(session, entry, name), None, 0.0
    if isinstance(entry, Controlled):
        return controlled(session, entry, name), None, 0.0
    return motion(session, entry, name, told)


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    panels, told, wall = [], None, 0.0
    print(f"{'profile':22s} {'time':>7s} {'samples':>8s} {'rms':>8s} {'max':>8s} {'as steps':>9s} {'ratio':>7s}")
    with Session() as session:
        for name in ORDER:
            panel, told, length = panel_of(session, name, told)
            panels.append(panel)
            wall += length
        used = f"{session.server_cpu():.1f} s of processor, with its start"
        print(f"the server used {used}, for {wall:.0f} s of motion, force control, a scan, zero and two batteries")
    if options.picture:
        draw(panels, options.picture)


if __name__ == "__main__":
    main()
