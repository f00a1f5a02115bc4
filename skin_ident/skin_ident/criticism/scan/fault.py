"""A fault seen in the table itself, without a model: its cause, and the cells that must not be used in fits."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skin_ident.criticism.vocabulary import Key


@dataclass(frozen=True, eq=False)
class Fault:
    """`bad` (N,) masks the cells to leave out; `why` is one sentence; `parameters` are in the format of findings.json; `alternatives` are
    (cause, where); `cells` lists single bad readings: where they are, what was read and what was expected."""

    cause: str
    where: str
    why: str
    bad: np.ndarray
    parameters: dict[str, dict[str, Any]] = field(default_factory=dict)
    alternatives: tuple[Key, ...] = ()
    cells: tuple[dict[str, Any], ...] = ()

    def among(self, mask: np.ndarray) -> "Fault":
        """The same fault, whose `bad` covers only the cells of a mask (N,), with `bad` extended to all N cells."""
        bad = np.zeros(mask.size, bool)
        bad[mask] = self.bad
        return replace(self, bad=bad)


def mm(length: float) -> str:
    """A length (m) in words."""
    return f"{1e3 * length:.4g} mm"
