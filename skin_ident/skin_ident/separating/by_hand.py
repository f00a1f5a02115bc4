"""Tests of causes that are more than a motion of the stage, for rivals that no motion tells apart."""

from collections.abc import Iterable

from skin_ident.criticism.vocabulary import BY_NAME

# Causes whose test (`needs` in the vocabulary) takes another target, skin or load, or a recording in the air. Those of all others are
# motions in contact, as the candidates are: where none of these tells two causes apart, they do not, either.
MORE_THAN_A_MOTION = (
    "cyclic_softening", "friction", "mount_compliance", "off_centre", "inertia", "gain_error", "force_offset", "drift", "crosstalk",
)  # fmt: skip


def shown_by_hand(causes: Iterable[str]) -> tuple[str, ...]:
    """What would show each of the `causes`, where that is more than a motion in contact; each test once."""
    return tuple(dict.fromkeys(BY_NAME[cause].needs for cause in causes if cause in MORE_THAN_A_MOTION))
