"""A battery: a list of profiles and actions run as one goal.

In YAML its numbers may be expressions in its arguments. After every profile the plunger rests for `rest_s`; the approach to where the
next one begins comes by itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

from skin_motion_profiles.entry import Entry, Group
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import names, several, text
from skin_motion_profiles.profile import Profile, seconds
from skin_motion_profiles.profiles.hold import Hold


@dataclass(frozen=True)
class Battery(Group):
    """Several entries, one after the other."""

    kind: ClassVar[str] = "battery"
    example: ClassVar = {"profiles": [{"type": "free_air"}, {"type": "step", "depth_mm": 1.0}, {"type": "free_air"}]}

    profiles: tuple[Entry, ...] = several("the entries", ...)
    arguments: Mapping[str, float] | None = names("names that the numbers of the entries may use, and their values")
    about: str = text("what it is for", "")
    rest_s: float = seconds("after every profile", 0.0)

    def check(self) -> None:
        """Raise `ProfileError` for an empty list, or one of something else than profiles."""
        if not self.profiles or not all(isinstance(e, Entry) for e in self.profiles):
            raise ProfileError(f"{self.label}: profiles must be a list of at least one profile")

    def entries(self) -> tuple[Entry, ...]:
        """The entries, with the rest after every profile."""
        rest = Hold(duration_s=self.rest_s, name="rest") if self.rest_s > 0.0 else None
        return tuple(e for entry in self.profiles for e in ((entry, rest) if rest and isinstance(entry, Profile) else (entry,)))
