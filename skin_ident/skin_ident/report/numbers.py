"""How numbers are printed: three significant digits, a customary unit, and never a NaN."""

import math
from typing import Any

import numpy as np

UNKNOWN = "–"
_ABSURD = 1e150
_SPACE, _THIN = "\u00a0", "\u202f"
_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

# By SI unit: (smallest magnitude, factor, unit as printed), the largest first; a value below all of them takes the last.
_SCALES = {
    "N": ((0.1, 1.0, "N"), (1e-4, 1e3, "mN"), (0.0, 1e6, "µN")),
    "m": ((5e-5, 1e3, "mm"), (0.0, 1e6, "µm")),
    "m/s": ((5e-5, 1e3, "mm/s"), (0.0, 1e6, "µm/s")),
    "s": ((0.1, 1.0, "s"), (0.0, 1e3, "ms")),
    "V": ((0.1, 1.0, "V"), (0.0, 1e3, "mV")),
    "kg": ((0.1, 1.0, "kg"), (0.0, 1e3, "g")),
    "N/s": ((0.1, 1.0, "N/s"), (0.0, 1e3, "mN/s")),
    "N*s/m^2": ((0.0, 1e-3, "N·s/m per mm"),),
    "ppm": ((0.0, 1.0, "µs per s"),),
    "m/N": ((0.0, 1e6, "µm/N"),),
}


def finite(value: Any) -> float | None:
    """`value` as a float, or None where it is not a finite number or is too large for any measurement (1e150)."""
    if isinstance(value, (bool, str)) or value is None:
        return None
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        return None
    if not abs(number) < _ABSURD:  # also false for NaN
        return None
    return number if abs(number) > 1.0 / _ABSURD else 0.0


def plain(value: Any, digits: int = 3) -> str:
    """A bare number with `digits` significant digits; an en dash where there is none."""
    number = finite(value)
    if number is None:
        return UNKNOWN
    if number == 0.0:
        return "0"
    exponent = _exponent(number, digits)
    if _needs_power(exponent):
        return f"{number / 10.0**exponent:.{digits - 1}f}".replace("-", "−") + _power(exponent)
    return _fixed(number, digits - 1 - exponent)


def _fixed(number: float, last: int) -> str:
    """The number rounded to its `last` decimal, which may be negative."""
    whole = round(number, last)
    text = f"{whole:,.{max(last, 0)}f}"
    return text.replace(",", _THIN if abs(whole) >= 1e4 else "").replace("-", "−")


def _needs_power(exponent: int) -> bool:
    return not -4 < exponent < 6


def _power(exponent: int) -> str:
    return f"{_SPACE}×{_SPACE}10{str(exponent).translate(_RAISED)}"


def _exponent(number: float, digits: int) -> int:
    """The decimal exponent of the number once it is rounded to `digits` significant digits: for 9.996 and three digits that of 10."""
    return math.floor(math.log10(abs(float(f"{number:.{digits - 1}e}"))))


def printed_unit(unit: str) -> str:
    """A unit as it is printed: `N*s/m` becomes N·s/m, `N/m^3` becomes N/m³, and the unit of a pure number is empty."""
    if unit == "1":
        return ""
    head, mark, power = unit.partition("^")
    raised = power.translate(_RAISED) if mark and power.lstrip("-").isdigit() else mark + power
    return (head + raised).replace("*", "·")


def scale(values: Any, unit: str) -> tuple[float, str]:
    """(factor, unit as printed) that suits the largest of `values`, given in the SI unit `unit`."""
    known = [abs(v) for v in map(finite, np.atleast_1d(np.asarray(values, dtype=object)).ravel()) if v is not None]
    largest = max(known, default=0.0)
    steps = _SCALES.get(unit)
    if steps is None:
        return 1.0, printed_unit(unit)
    if largest == 0.0:
        return steps[0][1:]
    return next(((factor, name) for least, factor, name in steps if largest >= least), steps[-1][1:])


def amount(value: Any, unit: str, std: Any = None, like: Any = None, digits: int = 3) -> str:
    """`value` (in the SI unit `unit`) with its unit and, where known, its standard error. `like` are values whose scale it shares."""
    number, spread = finite(value), finite(std)
    if number is None:
        return UNKNOWN
    factor, name = scale(like if like is not None else number, unit)
    text = _with_spread(number * factor, spread * factor) if spread else plain(number * factor, digits)
    return f"{text}{_SPACE}{name}" if name else text


def bare(value: Any, unit: str, std: Any = None, like: Any = None) -> str:
    """The same without the unit, for a table with the unit in its head."""
    return amount(value, unit, std, like).removesuffix(f"{_SPACE}{scale(like if like is not None else value, unit)[1]}")


def _with_spread(value: float, std: float) -> str:
    """A value with its standard error: `0.800 ± 0.008`, `58 ± 4`, `9.7 ± 1.6`. The standard error decides how many digits (up to six) are
    printed."""
    if value == 0.0 or std < 1e-6 * abs(value):
        return f"{plain(value)}{_SPACE}±{_SPACE}{plain(std, 1)}" if value == 0.0 else plain(value)
    power = math.floor(math.log10(std))
    counts = power - (1.05 < std / 10.0**power < 1.95)  # exponent of the last digit: one digit of the error, two after a 1
    first = math.floor(math.log10(abs(value)))
    digits = min(max(1, 1 + first - counts), 6)
    if _needs_power(_exponent(value, digits)):
        digits = max(digits, 3)
        exponent = _exponent(value, digits)
        scaled, spread = (plain(number / 10.0**exponent, shown) for number, shown in ((value, digits), (std, 1)))
        return f"({scaled}{_SPACE}±{_SPACE}{spread}){_power(exponent)}"
    last = digits - 1 - first  # not of the rounded value: 0.99 ± 0.58 is 1.0 ± 0.6
    decimals = max(last, 0)
    spread = f"{round(std, -counts):.{decimals}f}" if round(std, decimals) and std < 1e4 else plain(std, 1)
    return f"{_fixed(value, last)}{_SPACE}±{_SPACE}{spread}"


def span(low: Any, high: Any, unit: str, instead: Any = ()) -> str:
    """An interval, `1.0 to 2.0 N`. `instead` are values that decide its scale; without any, the ends do."""
    factor, name = scale([*instead] or [low, high], unit)
    low, high = finite(low), finite(high)
    if low is None or high is None:
        return UNKNOWN
    ends = [low * factor, high * factor]
    said = [plain(end, 2) for end in ends]
    if any("×" in s for s in said) and 1e-9 < max(map(abs, ends)) < 1.0:  # no exponent, as the other numbers in that unit have none
        decimals = 1 - _exponent(max(ends, key=abs), 2)
        said = [f"{end:.{decimals}f}".replace("-", "−") for end in ends]
    return f"{said[0]} to {said[1]}{_SPACE}{name}".rstrip()


def fall_span(low: float, high: float, before: float | None, unit: str, instead: Any = ()) -> str:
    """The interval of an error's fall in words. Where its upper end is larger than the error itself, only the lower end is given ("at
    least"). This can happen because the bootstrap redraws the error together with the fall, but it would read like a mistake."""
    if before is not None and high > before:
        return f"at least {amount(low, unit, like=[*instead] or [low, before], digits=2)}"
    return span(low, high, unit, instead)


def change(share: Any) -> str:
    """A relative change as a percentage with its sign."""
    number = finite(share)
    return ("+" if number is not None and number >= 5e-4 else "") + percent(share)


def percent(share: Any) -> str:
    """A share of 1 as a whole percentage, with a decimal below 10 %."""
    number = finite(share)
    if number is None:
        return UNKNOWN
    value = 100.0 * number
    value = value if abs(value) >= 0.05 else 0.0
    text = f"{value:.1f}" if 0.05 <= abs(value) < 9.95 else f"{value:.0f}"
    return f"{text.replace('-', '−')}{_SPACE}%"
