"""Static spread scans: taxel force for rows of depth and columns of distance from the taxel's centre, as thesis Table 4-10."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from .sizing import find_amplitude, rms
from .specimen import draw_specimen

THESIS_MM = np.array([0.0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12])


@dataclass(frozen=True)
class Scan:
    """Forces (N) of shape (depths, distances); depths and distances in m, `direction` "x" or "y"."""

    depths: np.ndarray
    distances: np.ndarray
    forces: np.ndarray
    direction: str = "x"


@dataclass(frozen=True)
class ScanTruth:
    """What is hidden in a scan, the noise-free forces, the width and stiffness that the plain Gaussian has."""

    cause: str | None
    form: str | None
    size: float
    amplitude: float
    noise_rms: float
    signals: list
    width: float
    stiffness: float


def _flat_top(r, z, a, p):
    return np.exp(-(np.abs(r) ** (2 + 2 * a)))


def _heavy_tail(r, z, a, p):
    return (1 - 0.3 * np.tanh(a)) * np.exp(-(r**2)) + 0.3 * np.tanh(a) / (1 + (r / 1.2) ** 2) ** 1.5


def _student(r, z, a, p):
    nu = 1 / (0.05 * a + 1e-9)
    return (1 + r**2 / nu) ** -nu


def _tent(r, z, a, p):
    mix = np.tanh(0.5 * a)
    return (1 - mix) * np.exp(-(r**2)) + mix * np.clip(1 - np.abs(r) / 1.7, 0, None)


def _widening(r, z, a, p):
    return np.exp(-((r / (1 + 0.1 * a * (z - 0.5))) ** 2))


def _narrow_at_first(r, z, a, p):
    return np.exp(-((r * (1 + 0.2 * a * np.exp(-z / 0.25))) ** 2))


def _anisotropic(r, z, a, p):
    return np.exp(-((r / (1 + (0.05 * a if p else 0.0))) ** 2))


def _aside(r, z, a, p):
    return np.exp(-((r - 0.05 * a) ** 2))


def _plain(r, z, a, p):
    return np.exp(-(r**2))


SHAPES = {
    "spread_shape": {"flat_top": _flat_top, "heavy_tail": _heavy_tail, "student": _student, "tent": _tent},
    "spread_depth": {"widening": _widening, "narrow_at_first": _narrow_at_first},
    "anisotropy": {"wider_in_y": _anisotropic},
    "off_centre": {"aside": _aside},
}
LEVELS = {
    "nonlinear_stiffness": {"fung": lambda f, z, a: f * (1 + 0.1 * a * np.expm1(2 * z)), "power": lambda f, z, a: f * z ** (0.05 * a)},
    "force_offset": {"constant": lambda f, z, a: f + 0.1 * a},
    "dead_zone": {"threshold": lambda f, z, a: np.maximum(f - 0.1 * a, 0)},
    "saturation": {"hard": lambda f, z, a: np.minimum(f, 12 / (1 + 0.3 * a))},
    "drift": {"by_row": lambda f, z, a: f + 0.2 * a * (z - z[0])},
}
CAUSES = {c: tuple(f) for c, f in {**SHAPES, **LEVELS}.items()} | {"quantization": ("coarse",), "data_error": ("copied_row",)}


def make_scan(cause=None, form=None, size=1.0, seed=0, thickness_mm=4, two_sided=False, noise_n=0.06, step_n=0.1):
    """Scans (one, or one in x and one in y for anisotropy) that hide `cause`, and a `ScanTruth`.

    `size`: RMS of what one Gaussian with force proportional to depth cannot absorb, over the noise's. Raises KeyError for unknown names.
    """
    rng = np.random.default_rng([seed, 77])
    skin = draw_specimen(rng, thickness_mm)
    depths = skin.depth_max * np.arange(1, 11) / 10
    side = THESIS_MM * 1e-3
    distances = np.concatenate([-side[:0:-1], side]) if two_sided or cause == "off_centre" else side
    form = form or (str(rng.choice(CAUSES[cause])) if cause else None)
    floor = float(np.hypot(noise_n, step_n / 12**0.5))
    both = cause == "anisotropy"

    def clean(a):
        return [_forces(skin, depths, distances, cause, form, a, along) for along in ((0, 1) if both else (0,))]

    scaled = cause in SHAPES or cause in LEVELS
    amplitude = find_amplitude(lambda a: rms(_unabsorbed(clean(a), depths, distances), None) / floor, size) if scaled else 1.0
    signals = clean(amplitude)
    scans = [Scan(depths, distances, _as_read(f, rng, noise_n, step_n, cause), "xy"[i]) for i, f in enumerate(signals)]
    return scans, ScanTruth(cause, form, size, amplitude, floor, signals, skin.width, skin.k1)


def _forces(skin, depths, distances, cause, form, a, along):
    r, z = distances / skin.width, (depths / skin.depth_max)[:, None]
    spread = SHAPES[cause][form] if cause in SHAPES else _plain
    forces = skin.k1 * depths[:, None] * spread(r, z, a, along)
    return LEVELS[cause][form](forces, z, a) if cause in LEVELS else forces


def _as_read(forces, rng, noise_n, step_n, cause):
    step = step_n * (5 if cause == "quantization" else 1)
    read = np.round((forces + noise_n * rng.standard_normal(forces.shape)) / step) * step
    if cause == "data_error":
        row = rng.integers(1, len(read) - 1)
        read[row] = read[row - 1]
    return np.round(read, 4)


def _unabsorbed(scans, depths, distances):
    """Residual of the best common Gaussian: width by a grid, stiffness by least squares."""
    forces = np.concatenate(scans)
    z = np.tile(depths, len(scans))[:, None]
    best = None
    for width in np.geomspace(0.002, 0.015, 120):
        shape = z * np.exp(-((distances / width) ** 2))
        left = forces - shape * np.sum(shape * forces) / np.sum(shape**2)
        if best is None or np.sum(left**2) < np.sum(best**2):
            best = left
    return best


def write_scan(scan, path) -> Path:
    """Write `depth_mm,f_0mm_n,f_1mm_n,…`, comma-separated, as the thesis's table."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    head = ",".join(["depth_mm", *(f"f_{d:g}mm_n" for d in np.round(1e3 * scan.distances, 4))])
    rows = [",".join(f"{v:g}" for v in np.round([1e3 * z, *row], 6)) for z, row in zip(scan.depths, scan.forces, strict=True)]
    path.write_text("\n".join([head, *rows]) + "\n")
    return path
