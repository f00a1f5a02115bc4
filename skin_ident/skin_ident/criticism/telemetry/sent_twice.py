"""Short blocks of readings that are sent twice in a row, as where a packet is repeated or a buffer is read again before it is filled.

`repeats` compares every window with all others, so that a window must be long to exceed chance. A block that follows itself is compared at
one distance only, its own length, and may be as short as half a dozen samples.

Chance is judged from the runs of equal readings that are no whole blocks. They become fewer with their length, and the fall from one length
to the next is continued to the length of the block: the fall at all distances together, which many runs tell, or at the block's own, where
what is periodic recurs, whichever is slower.

What is periodic is no block sent twice, but counts among those runs: hum, seen through a coarse converter, goes through the same readings
for as long as a hold lasts. Near half the sampling rate it alternates between two of them. Where its period is the block, it goes on for
longer than the block's repetition or, where noise interrupts it, on either side.
"""

from collections.abc import Iterator

import numpy as np

from skin_ident.stretches import changed, runs

SHORTEST = 6  # samples of a block
PERIODIC = 0.9  # share of a block's readings that recur at a fraction of its length where it is periodic in itself
RECURRING = 0.5  # share of those that change, and of the readings on either side, that recur where a block is periodic
MANY, FEW_MORE = 30, 3  # runs from which their fall is known, and the number by which luck may have made the next too few


def sent_twice(codes: list[np.ndarray], longest: int) -> Iterator[tuple[int, int, int, int, int, float]]:
    """Blocks of `SHORTEST` to `longest` readings that follow themselves, in readings given as codes (N,) for each recording: the recording,
    the start of the repetition and of its source, the length, the number of changes of reading in it, and the number of such blocks to be
    expected by chance. A reading that does not change counts for nothing: at rest, coarse readings repeat."""
    changes = [np.cumsum(np.append(0, changed(row))) for row in codes]
    readings, distances = sum(int(c[-1]) for c in changes), range(SHORTEST, longest + 1)
    whole, parts = [], []
    for d in distances:
        parts.append(np.zeros(0, int))
        for k, (row, c) in enumerate(zip(codes, changes, strict=True)):
            starts, ends = runs(row[d:] == row[:-d])
            lively = c[d + ends] - c[d + starts]
            full = ends - starts >= d
            full[full] = [not _goes_on(row, start, end, d) for start, end in zip(starts[full], ends[full], strict=True)]
            parts[-1] = np.append(parts[-1], lively[~full])
            whole += [(k, d, *map(int, block)) for block in zip(starts[full], ends[full], lively[full], strict=True)]
    if not whole or readings < MANY:  # of a sensor that stands still nothing is known
        return
    _, fall = _tail(_at_least(np.concatenate(parts), readings * len(distances)), FEW_MORE)
    for k, d, start, end, lively in whole:
        many, own = _tail(_at_least(parts[d - SHORTEST], readings))
        expected = many[-1] * max(fall, own) ** max(lively - (many.size - 1), 0)
        yield k, d + start, start, end - start, lively, float(len(distances) * expected)


def _goes_on(row: np.ndarray, start: int, end: int, d: int) -> bool:
    """Whether the readings of a row from `start` on, of which those up to `end` recur `d` later, are periodic: with a period of `d`, which
    they have for longer than two repetitions or on either side as well, or with one of half of it or less."""
    first, last = max(start - d, 0), end + 2 * d
    same = row[first + d : last] == row[first : last - d][: row.size - d - first]
    beside = np.append(same[: start - first], same[end - first :])
    recur = np.count_nonzero(beside) > RECURRING * beside.size
    return recur or end - start > 2 * d or is_periodic(row[start : end + d], d // 2)


def is_periodic(readings: np.ndarray, longest: int) -> bool:
    """Whether readings recur, but for a few, with a period of `longest` samples or less that they hold twice. Those that change must do so,
    too: a coarse reading that moves slowly is the same a few samples later, and yet not periodic."""
    changes = changed(readings)
    for p in range(2, min(longest, readings.size // 2) + 1):
        same, moves = readings[p:] == readings[:-p], changes[p:]
        if np.mean(same) >= PERIODIC and np.count_nonzero(same & moves) >= RECURRING * np.count_nonzero(moves):
            return True
    return False


def _at_least(lively: np.ndarray, readings: int) -> np.ndarray:
    """How many runs there are with at least 0, 1, 2, … changes, from the changes in each; with 0, as many as `readings`."""
    return np.append(readings, np.cumsum(np.bincount(lively, minlength=2)[:0:-1])[::-1])


def _tail(at_least: np.ndarray, more: int = 0) -> tuple[np.ndarray, float]:
    """The counts that are many, and the share of the last of them that the next count is, allowing for some `more`."""
    many = at_least[: max(int(np.count_nonzero(at_least >= MANY)), 1)]
    following = at_least[many.size] if many.size < at_least.size else 0
    return many, min((following + more) / max(many[-1], 1), 1.0)
