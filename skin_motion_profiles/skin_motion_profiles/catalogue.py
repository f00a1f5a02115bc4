"""All profiles, found by looking into `skin_motion_profiles.profiles`: a new profile is one new file there and nothing else."""

import importlib
import inspect
import pkgutil
from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from typing import Any

import skin_motion_profiles.profiles
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import check_names
from skin_motion_profiles.profile import Profile


@cache
def profiles() -> Mapping[str, type[Profile]]:
    """Every profile class by its kind, in the order of the files."""
    package = skin_motion_profiles.profiles
    modules = [importlib.import_module(f"{package.__name__}.{m.name}") for m in pkgutil.iter_modules(package.__path__)]
    return {c.kind: c for module in modules for c in vars(module).values() if _is_profile_of(c, module)}


def _is_profile_of(c: object, module: object) -> bool:
    return inspect.isclass(c) and issubclass(c, Profile) and not inspect.isabstract(c) and c.__module__ == module.__name__


def profile_from_dict(content: Any) -> Profile:
    """The profile that a mapping such as `{"type": "sine", "amplitude_mm": 0.3, "frequency_hz": 0.5}` describes.

    Raises `ProfileError`, one sentence, for an unknown type, an unknown or missing parameter, or a value out of range.
    """
    if not isinstance(content, Mapping):
        raise ProfileError("a profile must be a mapping such as {type: sine, amplitude_mm: 0.3, frequency_hz: 0.5}")
    given = dict(content)
    cls = profile_class(given.pop("type", None))
    check_names(cls, cls.kind, given)
    return cls(**given)


def profile_class(kind: Any) -> type[Profile]:
    """The class of a kind. Raises `ProfileError` listing what exists."""
    if kind is None:
        raise ProfileError(f"a profile needs a type, one of {', '.join(profiles())}")
    if not isinstance(kind, str) or kind not in profiles():
        near = get_close_matches(str(kind), profiles(), n=1)
        hint = f"did you mean {near[0]}?" if near else f"there are {', '.join(profiles())}"
        raise ProfileError(f"no profile has the type {kind!r}: {hint}")
    return profiles()[kind]
