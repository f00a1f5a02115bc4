"""Batteries as files: where they lie, and how arguments reach them.

    type: battery
    arguments: {depth_mm: 1.0, seed: 0}
    profiles:
      - {type: sine, amplitude_mm: 0.3*depth_mm, frequency_hz: 0.5}
"""

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from skin_models.errors import ModelError
from skin_models.strict_yaml import load_yaml
from skin_motion_profiles.errors import ProfileError

_PACKAGE = "skin_motion_profiles"


def battery_names() -> dict[str, Path]:
    """The batteries that come with this package or lie in its share folders, by the name of their file."""
    return {file.stem: file for folder in reversed(list(_folders())) for file in sorted(folder.glob("*.yaml"))}


def _folders() -> Iterator[Path]:
    here = Path(__file__).resolve().parent
    yield here.parent / "batteries"  # the source tree, also of a symlinked build
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "share" / _PACKAGE / "batteries"


def read_battery(name: Any) -> dict[str, Any]:
    """The content of a battery, by its name or by the path of its file. Raises `ProfileError`."""
    known = battery_names()
    if not isinstance(name, str):
        raise ProfileError(f"battery must be a name or a path, not {name!r}")
    if name not in known and not name.endswith((".yaml", ".yml")):
        raise ProfileError(f"there is no battery {name!r}; there are {', '.join(sorted(known))}")
    return read_mapping(known.get(name) or Path(name))


def read_mapping(path: Path) -> dict[str, Any]:
    """A YAML file that holds one mapping. Raises `ProfileError` naming the file."""
    try:
        content = parse(path.read_text(encoding="utf-8"), str(path))
    except (OSError, UnicodeDecodeError) as error:
        raise ProfileError(f"cannot read {path}: {getattr(error, 'strerror', None) or error}") from error
    if not isinstance(content, dict):
        raise ProfileError(f"{path} must hold a mapping that begins with type: or battery:")
    return content


def parse(text: str, label: str) -> Any:
    """YAML as plain objects. Raises `ProfileError` naming `label` and the place of the mistake."""
    try:
        return load_yaml(text)
    except ModelError as error:
        raise ProfileError(f"{label}: {error}") from error
    except yaml.YAMLError as error:
        raise ProfileError(f"{label} is not YAML: {' '.join(str(error).split())}") from error


def with_arguments(battery: Mapping[str, Any], values: Mapping[str, Any]) -> dict[str, Any]:
    """The same battery with other values for its arguments. Raises `ProfileError` for one that it does not have."""
    arguments = battery.get("arguments") or {}
    for key in values:
        if not isinstance(arguments, Mapping) or key not in arguments:
            known = f"it takes {', '.join(arguments)}" if arguments else "it takes none"
            raise ProfileError(f"{battery.get('name') or 'the battery'} has no argument {key!r}: {known}")
    return {**battery, "arguments": {**arguments, **values}} if values else dict(battery)
