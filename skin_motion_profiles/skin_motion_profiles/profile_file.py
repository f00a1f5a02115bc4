"""Profiles as text: what a goal carries and a YAML file holds."""

from typing import Any

import yaml

from skin_motion_profiles.catalogue import profile_from_dict
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.profile import Profile


def profile_from_text(text: str) -> Profile:
    """The profile that YAML text describes. Raises `ProfileError` with one sentence."""
    return profile_from_dict(parse(text, "the profile"))


def parse(text: str, label: str) -> Any:
    """YAML as plain objects. Raises `ProfileError` naming `label` and the place of the mistake."""
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        raise ProfileError(f"{label} is not YAML: {' '.join(str(error).split())}") from error
