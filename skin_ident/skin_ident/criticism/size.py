"""Whether a search fits into memory: every cause at every taxel bends every channel, so it grows with the square of the taxels."""

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.proposals import directions
from skin_ident.criticism.session import prepare

MOST_BYTES = 3e9
COPIES = 3  # of the bank of directions that are held at once
FEW = 8


def check_size(recordings: list) -> None:
    """Raise `DiagnosisError` where a search on these training recordings would take more than `MOST_BYTES`."""
    if len(recordings[0].taxels) <= FEW:
        return
    first = prepare(recordings[0])
    numbers = len(directions(first)) * first.measured.size * sum(map(len, recordings)) / len(recordings[0])
    if 8 * COPIES * numbers > MOST_BYTES:
        raise DiagnosisError(
            f"causes cannot be sought in {first.n_taxels} taxels at once (that would take {8e-9 * COPIES * numbers:.0f} GB of memory): "
            f"name those of interest with --taxels, {FEW} or so"
        )
