"""What was found wrong in reading goes with what fails afterwards: a file that is cut off explains why nothing moves in it."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from skin_models.errors import SkinError


@contextmanager
def with_warnings_of(recordings: Sequence) -> Iterator[None]:
    """Add the warnings of recordings (scans have none) to a `SkinError` that is raised meanwhile, as far as it does not hold them."""
    try:
        yield
    except SkinError as error:
        each = [(r.name, w) for r in recordings for w in getattr(r, "warnings", ()) if w not in str(error)]
        said = [w if w.startswith(name) else f"{name}: {w}" for name, w in each]
        if not said:
            raise
        raise type(error)(f"{error} (in reading: {'; '.join(said)})") from error
