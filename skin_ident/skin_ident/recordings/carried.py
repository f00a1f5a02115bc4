"""What was found wrong in reading goes with what fails afterwards: a file that is cut off explains why nothing moves in it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from skin_models.errors import SkinError


def said_of(name: str, warning: str) -> str:
    """A warning with the recording that it is about in front, unless it begins with it: the notes on a bare file name that file."""
    return warning if warning.startswith((f"{name}: ", f"{name} is ")) else f"{name}: {warning}"


@contextmanager
def with_warnings_of(recordings: Sequence) -> Iterator[None]:
    """Add the warnings of recordings (scans have none) to a `SkinError` that is raised meanwhile, as far as it does not hold them."""
    try:
        yield
    except SkinError as error:
        each = [(r.name, w) for r in recordings for w in getattr(r, "warnings", ()) if w not in str(error)]
        said = [said_of(name, w) for name, w in each]
        if not said:
            raise
        raise type(error)(f"{error} (in reading: {'; '.join(said)})") from error
