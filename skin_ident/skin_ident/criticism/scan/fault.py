"""What a look at the table itself returns: a cause that needs no model, and the cells that must not be believed."""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skin_ident.criticism.vocabulary import Key


@dataclass(frozen=True, eq=False)
class Fault:
    """`bad` (N,) masks cells; `why` is one sentence; `parameters` as findings.json writes them; `alternatives` are (cause, where);
    `cells` says of single readings where they stand, what they read and what was expected."""

    cause: str
    where: str
    why: str
    bad: np.ndarray
    parameters: dict[str, dict[str, Any]] = field(default_factory=dict)
    alternatives: tuple[Key, ...] = ()
    cells: tuple[dict[str, Any], ...] = ()

    def among(self, mask: np.ndarray) -> "Fault":
        """A fault of the cells of a mask (N,) as one of all cells."""
        bad = np.zeros(mask.size, bool)
        bad[mask] = self.bad
        return replace(self, bad=bad)


def mm(length: float) -> str:
    """A length (m) in words."""
    return f"{1e3 * length:.4g} mm"
