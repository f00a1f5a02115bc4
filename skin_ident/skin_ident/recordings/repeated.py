"""Finds sessions that were given twice. Fitted as two, they would seem to halve a variance without new information."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from skin_ident.recordings.recording import Recording

ALIKE = 1e-6  # of a channel's range: differences up to this may be rounding in a table


def without_repeats(recordings: Sequence[Recording]) -> list[Recording]:
    """The recordings with each measurement once; the first of several equal ones gets a warning."""
    out: list[Recording] = []
    for r in recordings:
        first = next((i for i, kept in enumerate(out) if same(kept, r)), None)
        if first is None:
            out.append(r)
        else:
            twin = f"{r.name} (given twice)" if r.name == out[first].name else r.name
            out[first] = replace(out[first], warnings=(*out[first].warnings, f"{twin} holds the same samples: they count once"))
    return out


def first_repeat(recordings: Sequence[Recording]) -> tuple[int, int] | None:
    """The indices of two recordings that hold the same measurement, or None."""
    return next(((i, j) for j, b in enumerate(recordings) for i, a in enumerate(recordings[:j]) if same(a, b)), None)


def same(a: Recording, b: Recording) -> bool:
    """Whether two recordings hold the same measurement, noise and all."""
    rows = [(a.channels | ({} if a.depth is None else {"depth": a.depth})), (b.channels | ({} if b.depth is None else {"depth": b.depth}))]
    if len(a) != len(b) or rows[0].keys() != rows[1].keys():
        return False
    return all(np.max(np.abs(y - rows[1][name])) <= ALIKE * np.ptp(y) for name, y in rows[0].items())
