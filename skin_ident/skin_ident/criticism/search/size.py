"""How many taxels can be searched together. Every cause at every taxel changes every channel, so memory grows with the square of their
number.
"""

from dataclasses import replace

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.sessions.session import prepare

WANTED_BYTES, MOST_BYTES = 1.8e9, 6e9  # memory wanted for a search; and the most for one with the fewest taxels, beyond which it is refused
COPIES = 7  # copies of all directions that exist at the peak of a search
FEWEST = 3  # taxels that are searched together at least


def affordable(recordings: list, most: int) -> int:
    """The number of taxels, at most `most`, that a search on these training recordings should take together.

    Raises `DiagnosisError` where memory does not suffice for `FEWEST`.
    """
    first = prepare(recordings[0])
    each = _directions(first, 3) - _directions(first, 2)
    shared, others = _directions(first, 2) - 2 * each, len(first.channels) - first.n_taxels
    samples = first.t.size * sum(map(len, recordings)) / len(recordings[0])
    sizes = {k: 8.0 * COPIES * (shared + k * each) * (others + k) * samples for k in range(FEWEST, most + 1)}
    if sizes[FEWEST] > MOST_BYTES:
        raise DiagnosisError(
            f"these recordings are too long for causes to be sought in {first.n_taxels} taxels (that would take "
            f"{1e-9 * sizes[FEWEST]:.0f} GB of memory): give fewer or shorter ones, or name two taxels of interest with --taxels"
        )
    return max((k for k, size in sizes.items() if size <= WANTED_BYTES), default=FEWEST)


def _directions(session, taxels: int) -> int:
    """The number of directions for so many taxels."""
    names = tuple(c for c in session.channels if not c.startswith("taxel"))
    return len(directions(replace(session, channels=(*names, *(f"taxel_{i}" for i in range(taxels))))))
