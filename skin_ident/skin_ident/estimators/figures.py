"""Numbers printed for a terminal: as many digits as the uncertainty allows, and no exponent where none is needed."""

import math

LARGEST, SMALLEST = 1e7, 1e-4  # numbers outside this range are printed with an exponent


def figures(value: float, digits: int = 2) -> str:
    """`value` with so many significant digits: 0.0031, 3.1, 31, 310."""
    if not math.isfinite(value) or value == 0.0 or not SMALLEST <= abs(value) < LARGEST:
        return f"{value:.{digits}g}"
    return f"{round(value, _places(value, digits)):.{max(0, _places(value, digits))}f}"


def plus_minus(value: float, half: float) -> str:
    """`12.3 ± 1.4`: both to the second digit of `half`, or to the unit where that is coarser."""
    if not math.isfinite(half) or half <= 0.0 or not SMALLEST <= half < LARGEST:
        return f"{value:.3g} ± {half:.2g}"
    places = max(0, _places(half, 2))
    return f"{value:.{places}f} ± {half:.{places}f}"


def _places(value: float, digits: int) -> int:
    """Decimal places of the last of `digits` significant digits, after rounding to them."""
    return digits - 1 - math.floor(math.log10(abs(float(f"{value:.{digits - 1}e}"))))
