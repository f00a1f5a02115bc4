"""`skin_acuity OUT.png`: acuity of a patch of silicone skin against the pitch of its taxels, and over the patch itself."""

import argparse
import math
import sys
from pathlib import Path

from skin_models.acuity.patch import Patch, looked_at
from skin_models.errors import SkinError
from skin_models.layout import A201_AREA, Layout, grid
from skin_models.layout_file import load_layout
from skin_models.materials import silicone
from skin_models.spread.kernels import Gaussian
from skin_models.spread_by_thickness import silicone_spread
from skin_models.whole_file import whole_file

MOST = 2500  # taxels: each is looked at from every place of the map, and more would fill a memory
CONVERTER_NOISE = 4.88e-3 * 11.75 / math.sqrt(12.0)  # N: a 12 bit converter at the mean slope of the thesis's Table 3-1


def main(arguments: list[str] | None = None) -> int:
    """Draw the picture and say its numbers. Returns the exit status: 2 for what cannot be designed or written."""
    given = _parser().parse_args(arguments)
    try:
        _check_out(given.out)
        patch = _patch(given)
        print(looked_at(patch).sentence())
        from skin_models.acuity.drawing import png  # matplotlib: not before the arguments are known to be right

        with whole_file(given.out) as partial:
            partial.write_bytes(png(patch))
    except SkinError as error:
        return _complain(str(error))
    except OSError as error:
        return _complain(f"{given.out} cannot be written: {error.strerror}")
    print(f"wrote {given.out}")
    return 0


def _complain(sentence: str) -> int:
    print(f"skin_acuity: {sentence}", file=sys.stderr)
    return 2


def _check_out(out: Path) -> None:
    """Refuse a name that no picture can have. Raises `SkinError`."""
    if out.suffix.lower() != ".png":
        raise SkinError(f"the picture is a PNG: give it a name that ends in .png, not {str(out)!r}")
    if not out.parent.is_dir() or out.is_dir():
        raise SkinError(f"{out} cannot be written: name a file in a folder that exists")


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
    _check_sizes(given)
    thickness = 1e-3 * given.thickness_mm
    if not given.estimate_spread and not math.isclose(given.thickness_mm, 4.0):
        raise SkinError(f"the spread was measured at 4 mm, not at {given.thickness_mm:g} mm: pass --estimate-spread for an estimate")
    width = silicone_spread(thickness, given.estimate_spread)
    share = silicone(thickness, given.estimate_spread).model.dispersion.sensed_share
    name = f"{given.thickness_mm:g} mm silicone, spread {1e3 * width.value:.2f} ± {1e3 * width.std:.2f} mm"
    return Patch(_layout(given), Gaussian(width=width.value), given.noise_n, given.force_n, share, name)


def _check_sizes(given: argparse.Namespace) -> None:
    """Refuse what no skin is, before it overflows. Raises `SkinError`."""
    for name, value, unit, low, high in (
        ("--force-n", given.force_n, "N", 1e-6, 1e6),
        ("--noise-n", given.noise_n, "N", 1e-9, 1e6),
        ("--pitch-mm", given.pitch_mm, "mm", 1e-3, 1e6),
    ):
        if not low <= value <= high:
            raise SkinError(f"{name} must lie between {low:g} and {high:g} {unit}, not {value:g}")
    if given.layout is None and given.columns * given.rows > MOST:
        raise SkinError(f"{given.columns} x {given.rows} taxels are more than the {MOST} of one picture: draw a part of the skin")


def _layout(given: argparse.Namespace) -> Layout:
    if given.layout is not None:
        layout = load_layout(given.layout)
        if len(layout) > MOST:
            raise SkinError(f"{given.layout} has {len(layout)} taxels, more than the {MOST} of one picture: draw a part of the skin")
        return layout
    pitch = 1e-3 * given.pitch_mm
    return grid(given.columns, given.rows, pitch, min(A201_AREA, pitch**2))


if __name__ == "__main__":
    sys.exit(main())
