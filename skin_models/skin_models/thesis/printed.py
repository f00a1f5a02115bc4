"""A number as it was printed: its value and how many digits stand behind it."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Printed:
    """A printed number, such as `0.620`."""

    text: str

    @property
    def value(self) -> float:
        """The number."""
        return float(self.text)

    @property
    def half(self) -> float:
        """Half a unit of the last printed digit: what rounding may have taken or given."""
        _, _, decimals = self.text.partition(".")
        return 0.5 * 10.0 ** -len(decimals)

    def agrees(self, value: float, slack: float = 0.0) -> bool:
        """Whether `value`, give or take `slack`, rounds to the printed digits."""
        return bool(abs(value - self.value) <= self.half * (1.0 + 1e-9) + slack)

    def __str__(self) -> str:
        return self.text


def values(numbers: list[Printed]) -> np.ndarray:
    """The values of printed numbers, as an array."""
    return np.array([p.value for p in numbers])


def halves(numbers: list[Printed]) -> np.ndarray:
    """The rounding of printed numbers, as an array."""
    return np.array([p.half for p in numbers])
