"""`skin_acuity OUT.png`: acuity of a patch of silicone skin against the pitch of its taxels, and over the patch itself."""

import argparse
import math
import sys
from pathlib import Path

import numpy as np

from skin_models.acuity.patch import Patch, looked_at
from skin_models.errors import SkinError
from skin_models.layout import A201_AREA, Layout, grid
from skin_models.layout_file import load_layout
from skin_models.materials import silicone
from skin_models.spread.kernels import Gaussian
from skin_models.spread_by_thickness import silicone_spread
from skin_models.whole_file import whole_file

CONVERTER_NOISE = 4.88e-3 * 11.75 / math.sqrt(12.0)  # N: a 12 bit converter at the mean slope of the thesis's Table 3-1


def main(arguments: list[str] | None = None) -> int:
    """Draw the picture and say its numbers. Returns the exit status: 2 for what cannot be designed or written."""
    given = _parser().parse_args(arguments)
    try:
        patch = _patch(given)
        if not given.out.parent.is_dir() or given.out.is_dir():
            raise SkinError(f"{given.out} cannot be written: name a file in a folder that exists")
        print(looked_at(patch).sentence())
        from skin_models.acuity.drawing import png  # matplotlib: not before the arguments are known to be right

        with whole_file(given.out) as partial:
            partial.write_bytes(png(patch))
    except (SkinError, OSError) as error:
        print(f"skin_acuity: {error}", file=sys.stderr)
        return 2
    print(f"wrote {given.out}")
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="skin_acuity", description=__doc__.split(":", 1)[1].strip())
    parser.add_argument("out", type=Path, help="PNG to write")
    parser.add_argument("--thickness-mm", type=float, default=4.0, help="of the silicone (4)")
    parser.add_argument("--estimate-spread", action="store_true", help="estimate the spread where it was not measured: not 4 mm")
    parser.add_argument("--pitch-mm", type=float, default=10.0, help="of a square grid of FlexiForce A201 taxels (10)")
    parser.add_argument("--columns", type=int, default=5, help="of that grid (5)")
    parser.add_argument("--rows", type=int, default=5, help="of that grid (5)")
    parser.add_argument("--layout", type=Path, help="a table of taxels instead (name, x_mm, y_mm, …, area_mm2)")
    parser.add_argument("--noise-n", type=float, default=CONVERTER_NOISE, help=f"standard deviation of a reading ({CONVERTER_NOISE:.3g})")
    parser.add_argument("--force-n", type=float, default=5.0, help="of the contact that is located (5)")
    return parser


def _patch(given: argparse.Namespace) -> Patch:
    thickness = 1e-3 * given.thickness_mm
    if not given.estimate_spread and not math.isclose(given.thickness_mm, 4.0):
        raise SkinError(f"the spread was measured at 4 mm, not at {given.thickness_mm:g} mm: pass --estimate-spread for an estimate")
    width = silicone_spread(thickness, given.estimate_spread)
    share = silicone(thickness, given.estimate_spread).model.dispersion.sensed_share
    name = f"{given.thickness_mm:g} mm silicone, spread {1e3 * width.value:.2f} ± {1e3 * width.std:.2f} mm"
    return Patch(_layout(given), Gaussian(width=width.value), given.noise_n, given.force_n, share, name)


def _layout(given: argparse.Namespace) -> Layout:
    if given.layout is not None:
        return load_layout(given.layout)
    pitch = 1e-3 * given.pitch_mm
    return grid(given.columns, given.rows, pitch, min(A201_AREA, pitch**2) if np.isfinite(pitch) and pitch > 0.0 else None)


if __name__ == "__main__":
    sys.exit(main())
