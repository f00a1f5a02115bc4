"""Data that others measured, laid out as a user would: tables beside a rig.yaml. The folder is SKIN_MEASURED, or shared/measured above."""

import os
import shutil
from pathlib import Path

import numpy as np

PLACES = [Path(os.environ.get("SKIN_MEASURED", "/nowhere")), *(q / "shared/measured" for q in Path(__file__).resolve().parents)]
HERE = next((p for p in PLACES if p.is_dir()), None)
ABSENT = "the measured data are not at hand: set SKIN_MEASURED to their folder"

WATER = ("nowater", "10mm", "30mm", "50mm")
PRESSES = 9
INSOLE = ("experiment_Inf_15September_dynamic_1", "validation_dataset_3")
SCALE = 4.1448  # N/V, the authors' scaling of the load cell
FLUID_RIG = """\
sample_rate_hz: 100
force_step_n: 0.010571     # 2.5504 mV of the converter, times 4.1448 N/V
taxel_step_n: 0.0025504    # the unit of the pressure is not stated: volts are left as they are
calibration:
  ai0: {channel: force, slope_n_per_v: -4.1448}
  ai1: {channel: taxel_left, slope_n_per_v: 1}
  ai3: {channel: taxel_right, slope_n_per_v: 1}
"""
INSOLE_RIG = "taxel_step_n: 1    # counts; force_n is the pressure of the chamber in N/cm2\n"


def fluid_skin(folder: Path) -> Path:
    """The four files as they are: nine presses each, walking from the left sensor to the right one, under 0 to 50 mm of water."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(FLUID_RIG, encoding="utf-8")
    for name in WATER:
        shutil.copy(HERE / "sdu_fluid_skin" / f"1D_underwater_{name}.csv", folder / f"{name}.csv")
    return folder


def one_press(folder: Path, number: int) -> Path:
    """Press `number` (1 to 9) of every file alone, from 1.5 s before it to 5 s after."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(FLUID_RIG, encoding="utf-8")
    for name in WATER:
        rows = fluid_rows(name)
        start = starts(rows)[number - 1]
        header = "t_s,ai0_V,ai1_V,ai3_V"
        np.savetxt(folder / f"{name}.csv", rows[start - 150 : start + 500], "%.9g", ",", header=header, comments="")
    return folder


def fluid_rows(name: str) -> np.ndarray:
    """t s, load cell V, left V, right V as columns."""
    return np.genfromtxt(HERE / "sdu_fluid_skin" / f"1D_underwater_{name}.csv", delimiter=",", skip_header=1)


def starts(rows: np.ndarray) -> np.ndarray:
    """The samples at which the force first passes 1 N in each press."""
    force = -SCALE * (rows[:, 1] - np.median(rows[:100, 1]))
    up = np.flatnonzero((force[1:] > 1.0) & (force[:-1] <= 1.0))
    return up[np.concatenate([[True], np.diff(up) > 300])]


def insole(folder: Path) -> Path:
    """Pressure and 280 taxels, tared at rest, as tables; a taxel is called by its number in the file."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "rig.yaml").write_text(INSOLE_RIG, encoding="utf-8")
    for name in INSOLE:
        t, pressure, taxels = insole_rows(name)
        header = ",".join(["t_s", "force_n", *(f"taxel_{i}_n" for i in range(len(taxels)))])
        np.savetxt(folder / f"{name}.csv", np.vstack([t, 10.0 * pressure, taxels]).T, "%.9g", ",", header=header, comments="")
    return folder


def insole_rows(name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """t s, pressure bar, taxels (280, N) in counts less those of the first five seconds. The pressure has no clock of its own."""
    from scipy.io import loadmat

    e = loadmat(HERE / "iit_capacitive_skin" / f"{name}.mat", squeeze_me=True, struct_as_record=False)["experiment"]
    counts, pressure = np.asarray(e.C, float), np.asarray(e.P, float)
    n = min(len(counts), len(pressure))
    fall = 240.0 - counts[:n, 2:].T
    return counts[:n, 1] - counts[0, 1], pressure[:n], fall - np.median(fall[:, :250], axis=1, keepdims=True)
