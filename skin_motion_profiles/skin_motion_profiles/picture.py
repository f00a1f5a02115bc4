"""Pictures of motions: depth over time, in mm and s, with the skin below its surface as in the rig."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from skin_models.whole_file import whole_file
from skin_motion_profiles.catalogue import entries, entry_from_dict
from skin_motion_profiles.entry import Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.plan import Motion, Travel, stages

_TRAVEL = Travel(0.002, 0.05)
_LINE, _AIR, _FAINT = "#0b5c8a", "#eef3f6", "#888888"


def motions_of(entry: Entry, start: float) -> list[Motion]:
    """The motions of an entry as they follow from depth `start` (m), actions left out."""
    out: list[Motion] = []
    for stage in stages(entry):
        if stage.is_motion:
            out.append(stage.motion(out[-1].trajectory.end if out else start, _TRAVEL))
    return out


def gallery() -> dict[str, Entry]:
    """An example of every profile that moves."""
    examples = {kind: entry_from_dict({"type": kind, **cls.example}) for kind, cls in entries().items()}
    return {kind: entry for kind, entry in examples.items() if motions_of(entry, 0.0)}


def draw(named: Mapping[str, Entry], path: Path) -> None:
    """A page with one panel per entry; a single one is drawn large, with the names of its parts. The format follows from `path`.

    Raises `ProfileError` for an entry that does not move.
    """
    from matplotlib.figure import Figure  # not everyone who moves a plunger has a screen

    for name, entry in named.items():
        if not motions_of(entry, 0.0):
            raise ProfileError(f"{name} does not move: there is nothing to draw")
    columns = min(3, len(named))
    rows = -(-len(named) // columns)
    figure = Figure(figsize=(14.0, 5.0) if len(named) == 1 else (5.2 * columns, 2.7 * rows), layout="constrained")
    for i, (name, entry) in enumerate(named.items()):
        axes = figure.add_subplot(rows, columns, i + 1)
        _panel(axes, name, motions_of(entry, 0.0))
        if len(named) == 1:
            _name_parts(axes, motions_of(entry, 0.0))
    with whole_file(path) as partial:
        figure.savefig(partial, dpi=110, format=path.suffix[1:])


def _panel(axes: Any, name: str, motions: list[Motion]) -> None:
    begin = 0.0
    for trajectory in (m.trajectory for m in motions):
        t = trajectory.knots(trajectory.duration / 4000)
        axes.plot(begin + t, trajectory.sample(t).x * 1e3, color=_LINE, lw=1.2)
        begin += trajectory.duration
    axes.axhline(0.0, color=_FAINT, lw=0.6)
    low, high = axes.get_ylim()
    axes.axhspan(min(low, 0.0), 0.0, color=_AIR, zorder=0, lw=0)
    axes.set(xlim=(0.0, begin), ylim=(high, low), xlabel="time / s", ylabel="depth / mm")  # down is into the skin
    peak = max(m.trajectory.reach().speed for m in motions)
    axes.set_title(f"{name}   {begin:.1f} s, up to {peak * 1e3:.3g} mm/s", fontsize=9, loc="left")


def _name_parts(axes: Any, motions: list[Motion]) -> None:
    """The names of the parts above the frame, where no curve crosses them, and the title above those."""
    axes.figure.suptitle(axes.get_title(loc="left"), fontsize=9, x=0.01, ha="left")
    axes.set_title("", loc="left")
    begin = 0.0
    for motion in motions:
        for name, t in zip(motion.names, motion.begins, strict=True):
            axes.axvline(begin + t, color=_FAINT, lw=0.5, ls=":")
            axes.annotate(name, (begin + t, 1.0), (0, 3), xycoords=("data", "axes fraction"), textcoords="offset points",
                          rotation=50, rotation_mode="anchor", va="bottom", ha="left", fontsize=7, color=_FAINT)  # fmt: skip
        begin += motion.trajectory.duration
