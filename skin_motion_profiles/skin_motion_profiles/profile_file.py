"""Profiles as text: what a goal carries and a YAML file holds."""

from skin_motion_profiles.battery_file import parse
from skin_motion_profiles.catalogue import entry_from_dict
from skin_motion_profiles.entry import Entry


def entry_from_text(text: str) -> Entry:
    """What YAML text describes. Raises `ProfileError` with one sentence."""
    return entry_from_dict(parse(text, "the profile"))
