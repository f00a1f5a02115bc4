"""Adds warnings from reading to errors of later steps: that a file is cut off, for instance, explains why nothing moves in it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from skin_models.errors import SkinError


def said_of(name: str, warning: str) -> str:
    """A warning with the recording's name in front, unless it begins with it already."""
    return warning if warning.startswith((f"{name}: ", f"{name} is ")) else f"{name}: {warning}"


@contextmanager
def with_warnings_of(recordings: Sequence) -> Iterator[None]:
    """Add the warnings of recordings (scans have none) to a `SkinError` that is raised in the block, unless its text holds them already."""
    try:
        yield
    except SkinError as error:
        each = [(r.name, w) for r in recordings for w in getattr(r, "warnings", ()) if w not in str(error)]
        said = [said_of(name, w) for name, w in each]
        if not said:
            raise
        raise type(error)(f"{error} (in reading: {'; '.join(said)})") from error
