"""Incremental force control (thesis, section 3.2.2) beside the explicit one (its future work): a step from contact to 5 N.

Overshoot is beyond 5 N, settled is for good within 5 % (0.25 N; the load cell's own step is 0.07 N), chatter is the standard deviation
over the last three seconds, rise is the time from contact to the first force within 5 %. Each control presses on the same simulated skins.
--picture FILE draws the forces.
"""

import argparse
from pathlib import Path

import numpy as np
import yaml
from session import Session

FORCE = 5.0  # N
BAND = 0.05 * FORCE
SECONDS = 12.0
ROOM = {"deepest_mm": 2.0, "highest_mm": -0.2}
# Sum of k1 and k2 in N/mm, Table 4-5 of the thesis.
STIFFNESS = {"2 mm": 26.6, "4 mm": 12.4, "6 mm": 9.9}
MODELS = {
    "2 mm": {"m": 0.000216, "b1": 1330.0, "k1": 25042.0, "b2": 590.2, "k2": 1603.0},
    "4 mm": {"m": 0.000432, "b1": 939.5, "k1": 9619.0, "b2": 629.2, "k2": 2766.0},
    "6 mm": {"m": 0.000648, "b1": 248.6, "k1": 4338.0, "b2": 758.3, "k2": 5600.0},
}
UNITS = {"m": "kg", "b1": "N*s/m", "k1": "N/m", "b2": "N*s/m", "k2": "N/m"}


def controls(skin: str) -> dict[str, dict]:
    """The goals to compare."""
    incremental = {"type": "incremental_force", "force_n": FORCE, "duration_s": SECONDS, **ROOM}
    ramp = {"forces_n": FORCE, "ramp_n_s": 10, "hold_s": SECONDS - 0.5}
    explicit = {"type": "explicit_force", "stiffness_n_mm": STIFFNESS[skin], **ramp, **ROOM}
    return {
        "incremental 0.01 mm": incremental,
        "incremental 0.01 mm, tolerance 0.2 N": {**incremental, "tolerance_n": 0.2},
        "incremental 0.01 mm at 0.2 mm/s": {**incremental, "speed_mm_s": 0.2},
        "explicit 3 rad/s": explicit,
        "explicit 3 rad/s, stiffness halved": {**explicit, "stiffness_n_mm": 0.5 * STIFFNESS[skin]},
        "explicit 6 rad/s": {**explicit, "bandwidth_rad_s": 6},
    }


def measures(t: np.ndarray, force: np.ndarray) -> tuple[float, float, float, float, float]:
    """Overshoot (N), rise (s), time to settled (s; NaN: not a second before the end), error and deviation of the last 3 s (N)."""
    outside = t[np.abs(force - FORCE) > BAND]
    settled = outside[-1] if outside[-1] < t[-1] - 1.0 else float("nan")
    late = force[t > t[-1] - 3.0]
    rise = t[np.argmax(np.abs(force - FORCE) <= BAND)]
    return max(float(force.max()) - FORCE, 0.0), float(rise), settled, float(late.mean()) - FORCE, float(late.std())


def press(session: Session, goal: dict) -> tuple[np.ndarray, np.ndarray]:
    """Times (s) from contact and forces (N)."""
    result, _, _ = session.execute("{type: straight_line, to_mm: -0.05, speed_mm_s: 2}")
    if result.error_code != 0:
        raise SystemExit(result.error_string)
    result, _, force = session.execute(yaml.safe_dump(goal))
    if result.error_code != 0:
        raise SystemExit(f"{goal['type']}: {result.error_string}")
    t = force[:, 0] - force[np.argmax(force[:, 1] >= 0.3), 0]
    within = (t >= -0.5) & (t <= SECONDS)
    return t[within], force[within, 1]


def model_file(skin: str, folder: Path) -> str:
    """A specimen as the driver reads it."""
    path = folder / f"{skin.replace(' ', '_')}.yaml"
    dispersion = {name: {"value": value, "unit": UNITS[name]} for name, value in MODELS[skin].items()}
    path.write_text(yaml.safe_dump({"schema": 1, "name": skin, "dispersion": dispersion}))
    return str(path)


def draw(runs: dict[tuple[str, str], tuple[np.ndarray, np.ndarray]], path: Path) -> None:
    """A column per skin: incremental control above, explicit control below."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(15, 7), layout="constrained")
    grid = figure.subplots(2, len(MODELS), sharex=True, sharey=True)
    for row, kind in zip(grid, ("incremental", "explicit"), strict=True):
        for axes, skin in zip(row, MODELS, strict=True):
            mine = [(name, run) for (of, name), run in runs.items() if of == skin and name.startswith(kind)]
            for (name, (t, force)), color in zip(mine, ("#0b5c8a", "#e08a2e", "#3a9b5c"), strict=True):
                axes.plot(t, force, lw=0.8, color=color, label=name)
            axes.axhspan(FORCE - BAND, FORCE + BAND, color="#dddddd", zorder=0)
            axes.set_title(f"{kind}, silicone {skin}", fontsize=10, loc="left")
            axes.grid(lw=0.3)
        row[0].set_ylabel("force / N")
        row[-1].legend(fontsize=8, loc="lower right")
    for axes in grid[-1]:
        axes.set(xlabel="time from contact / s", xlim=(-0.5, 6.0))
    figure.savefig(path, dpi=100)


def main() -> None:
    """Entry point."""
    import tempfile

    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    runs = {}
    print(f"{'skin':5s} {'control':38s} {'overshoot':>9s} {'rise':>9s} {'settled':>9s} {'error':>8s} {'chatter':>8s}")
    with tempfile.TemporaryDirectory() as folder:
        for skin in MODELS:
            with Session(driver={"model": model_file(skin, Path(folder))}) as session:
                for name, goal in controls(skin).items():
                    t, force = runs[skin, name] = press(session, goal)
                    over, rise, settled, error, chatter = measures(t, force)
                    print(f"{skin:5s} {name:38s} {over:7.2f} N {rise:7.2f} s {settled:7.2f} s {error:6.2f} N {chatter:6.2f} N", flush=True)
    if options.picture:
        draw(runs, options.picture)


if __name__ == "__main__":
    main()
