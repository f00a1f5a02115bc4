"""How well a patch of skin locates a contact, against the pitch of its taxels: table, and a picture with --picture FILE.

The skin is the thesis's 4 mm silicone with FlexiForce A201 taxels read by a 12 bit converter. The Cramér-Rao bound stands beside the error
of the most likely place over noisy readings.
"""

import argparse

import numpy as np

from skin_models.design import Acuity, Design, acuity, localisation_bound, monte_carlo
from skin_models.layout import A201_AREA, grid
from skin_models.materials import material
from skin_models.spread.kernels import Gaussian

SKIN = material("silicone_4mm")
PEAK, FORCE = SKIN.model.dispersion.sensed_share, 5.0  # N
LSB = 4.88e-3 * 11.75  # N, of the converter at the mean slope of Table 3-1
NOISE = LSB / np.sqrt(12.0)
PITCHES = np.arange(4, 17) * 1e-3


def simulated(pitch: float, trials: int = 400) -> tuple[float, float]:
    """Median bound and median error of the most likely place over random contacts in the middle of a patch, m."""
    design = Design(grid(8, 8, pitch, min(A201_AREA, pitch**2)), Gaussian(width=SKIN.spread_width), NOISE, PEAK)
    places = np.random.default_rng(0).uniform(-0.5, 0.5, (16, 2)) * pitch
    return float(np.median(localisation_bound(design, places, FORCE))), float(np.median(monte_carlo(design, places, FORCE, trials, 1)))


def draw(rows: list[Acuity], errors: list[float], path: str) -> None:
    """Error against pitch, beside the map of the error over one cell of the thesis's pitch."""
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.5), layout="constrained")
    mm = [1e3 * a.pitch for a in rows]
    left.semilogy(mm, mm, "k:", label="the pitch itself")
    left.semilogy(mm, [1e3 * a.error_worst for a in rows], "C1", label="bound, worst place")
    left.semilogy(mm, [1e3 * a.error_median for a in rows], "C0", label="bound, median")
    left.semilogy(mm, [1e3 * e for e in errors], "C0o", label="most likely place, simulated")
    left.set(xlabel="pitch of the taxels, mm", ylabel="error of the position, mm", ylim=(1e-2, 1e3), title=f"{FORCE:g} N on 4 mm silicone")
    left.legend()
    u = np.linspace(-14e-3, 14e-3, 181)
    design = Design(grid(5, 5, 14e-3, A201_AREA), Gaussian(width=SKIN.spread_width), NOISE, PEAK)
    error = localisation_bound(design, np.stack(np.meshgrid(u, u), axis=-1).reshape(-1, 2), FORCE).reshape(181, 181)
    image = right.imshow(np.log10(1e3 * error), extent=[-14, 14, -14, 14], origin="lower", vmin=-2, vmax=2)
    figure.colorbar(image, label="log10 of the error, mm")
    right.set(xlabel="x, mm", ylabel="y, mm", title="14 mm pitch, as in the thesis; taxels at 0, ±14 mm")
    figure.savefig(path, dpi=120)


def main() -> None:
    """Print the table, draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--picture", metavar="FILE", help="draw it, too")
    path = parser.parse_args().picture
    rows = acuity(SKIN.spread_width, PITCHES, FORCE, NOISE, PEAK)
    print("pitch   bound: median      worst    most likely place    weakest force told anywhere")
    errors = []
    for a in rows:
        bound, error = simulated(a.pitch)
        errors.append(error)
        print(f"{1e3 * a.pitch:3.0f} mm {1e3 * a.error_median:10.3f} {1e3 * a.error_worst:10.3f} mm", end="")
        print(f" {1e3 * error:8.3f} ({error / bound:5.2f} x bound) {a.force_worst:8.2f} N")
    if path:
        draw(rows, errors, path)


if __name__ == "__main__":
    main()
