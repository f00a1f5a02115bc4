"""Text for a person that carries its numbers for programs."""

from collections.abc import Iterable
from typing import Any


class Said(str):
    """A text. `sizes` are its numbers: {"value", "unit"}, with "at_s" for a value that begins or is reached at a moment. `whole` is their
    sum where they add up. `under_way`: something changed after the session had begun. `crept`: the value differs between beginning and end,
    and no moment of a jump is known."""

    sizes: tuple[dict[str, Any], ...] = ()
    under_way: bool = False
    crept: bool = False
    whole: dict[str, Any] | None = None

    @classmethod
    def of(
        cls,
        words: str,
        values: Iterable[float],
        unit: str,
        moments: Iterable[float] | None = None,
        *,
        under_way: bool = False,
        crept: bool = False,
        adds_up: bool = False,
    ) -> "Said":
        """`values` in `unit` (SI), each at its moment, s, or without moments if constant throughout. `adds_up`: each is added to those
        before it."""
        said = cls(words)
        sizes = [{"value": float(v), "unit": unit} for v in values]
        said.sizes = tuple(sizes if moments is None else ({**q, "at_s": float(m)} for q, m in zip(sizes, moments, strict=True)))
        said.under_way, said.crept = under_way, crept
        said.whole = {"value": sum(q["value"] for q in sizes), "unit": unit} if adds_up else None
        return said
