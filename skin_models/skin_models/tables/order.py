"""Stamps that grow: late samples are sorted in, repeats dropped, all of it counted; a clock that steps back is refused."""

from dataclasses import dataclass

import numpy as np

from skin_models.errors import TableError
from skin_models.words import counted

OFTEN = 0.01  # share of all samples: more steps back than this are no single event
LATE_RUN = 3  # more samples in a row than this behind the newest one are no longer "late" but a clock that stepped back


@dataclass(frozen=True)
class Mended:
    """How many samples had to be put right before the stamps grew: those without a stamp were dropped, late ones sorted in, and of repeated
    stamps all but the first dropped."""

    unstamped: int = 0
    late: int = 0
    repeated: int = 0

    @property
    def notes(self) -> tuple[str, ...]:
        """The same as sentences."""
        said = (
            (self.unstamped, f"{counted(self.unstamped, 'sample')} without a time stamp dropped"),
            (self.late, f"{counted(self.late, 'sample')} out of order sorted by time"),
            (self.repeated, f"{counted(self.repeated, 'repeated time stamp')} dropped, the first sample of each kept"),
        )
        return tuple(words for count, words in said if count)


def in_order(t: np.ndarray, name: str) -> tuple[np.ndarray | None, Mended]:
    """Indices that put the samples with stamps t (N,), s or whole ns, into an order in which finite stamps grow, and what was mended.

    None in place of the indices: all samples are in order. Raises `TableError` where the clock steps back.
    """
    finite = np.isfinite(t)
    if finite.all() and np.all(t[1:] > t[:-1]):
        return None, Mended()
    index = np.flatnonzero(finite)
    unstamped, late = t.size - index.size, _late(t[index], name)
    if late:
        index = index[np.argsort(t[index], kind="stable")]
    repeated = np.concatenate([np.zeros(min(index.size, 1), bool), np.diff(t[index]) <= 0])
    return index[~repeated], Mended(int(unstamped), late, int(repeated.sum()))


def _late(t: np.ndarray, name: str) -> int:
    """How many samples have a stamp before that of an earlier one. Raises `TableError` where these are not single late samples."""
    newest = np.maximum.accumulate(t)
    behind = t < newest
    if behind.size <= LATE_RUN or not np.lib.stride_tricks.sliding_window_view(behind, LATE_RUN + 1).all(axis=1).any():
        return int(behind.sum())
    if np.all(np.diff(t) <= 0):
        raise TableError(f"{name}: its time runs backwards, from the last sample to the first; sort its rows by time")
    first = int(np.argmax(behind))
    if np.sum(np.diff(t) < 0) > max(3, OFTEN * t.size):
        share = f"{100 * behind.mean():.0f} % of its stamps lie behind earlier ones"
        raise TableError(f"{name}: {share}: two publishers on one topic, or a clock that jumps to and fro")
    back = (newest[first] - t[first]) * (1e-9 if np.issubdtype(t.dtype, np.integer) else 1.0)
    raise TableError(f"{name}: the clock steps back by {back:.3g} s at sample {first}; cut it there, or repair its stamps")
