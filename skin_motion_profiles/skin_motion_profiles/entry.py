"""What a goal or a battery may list: profiles (motions), actions (zero, tare, moving the x-y stage), controlled motions, and groups.

An entry is a final frozen dataclass with named parameters in a file of `skin_motion_profiles.profiles`. What it does follows from which
of the abstract classes it extends: `Profile` (see `skin_motion_profiles.profile`), `Action`, `Controlled` or `Group`.
"""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

from skin_motion_profiles.fields import check_values, text


@dataclass(frozen=True)
class Entry(ABC):
    """Parameters under one name. `kind` is the word after `type:` in YAML. Raises `ProfileError` for a parameter out of range."""

    kind: ClassVar[str]
    example: ClassVar[Mapping[str, Any]]  # parameters of ordinary size, for pictures and descriptions

    name: str = text("what the feedback calls it; left out: its type", "")

    def __post_init__(self) -> None:
        check_values(self, self.kind)
        self.check()

    def check(self) -> None:  # noqa: B027  (most entries have nothing to add)
        """Raise `ProfileError` where parameters contradict each other."""

    @property
    def label(self) -> str:
        """What to call it."""
        return self.name or self.kind


@dataclass(frozen=True)
class Action(Entry, ABC):
    """Something that is asked of the driver or of a person between two motions."""


@dataclass(frozen=True)
class Group(Entry, ABC):
    """Several entries, one after the other."""

    @abstractmethod
    def entries(self) -> tuple[Entry, ...]:
        """What it consists of; groups may hold groups."""


def leaves(entry: Entry) -> Iterator[Entry]:
    """Everything that is to be done, in order, with all groups dissolved."""
    if isinstance(entry, Group):
        for part in entry.entries():
            yield from leaves(part)
    else:
        yield entry
