"""Profiles as text: what a goal carries, a YAML file holds and a person types."""

from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml

from skin_motion_profiles.battery_file import battery_names, parse, read_battery, read_mapping, with_arguments
from skin_motion_profiles.catalogue import entries, entry_from_dict
from skin_motion_profiles.entry import Entry
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.fields import declared


def entry_from_text(text: str) -> Entry:
    """What YAML text describes. Raises `ProfileError` with one sentence."""
    return entry_from_dict(parse(text, "the profile"))


def entry_to_text(entry: Entry) -> str:
    """YAML text that `entry_from_text` reads back as the same entry, with every expression and every named battery written out."""
    return yaml.safe_dump(_plain(entry), sort_keys=False, allow_unicode=True, width=140)


def _plain(value: Any) -> Any:
    if isinstance(value, Entry):
        set_fields = {f.name: getattr(value, f.name) for f in declared(type(value)) if getattr(value, f.name) != f.default}
        return {"type": value.kind, **{name: _plain(v) for name, v in set_fields.items()}}
    if isinstance(value, (list, tuple)):
        return [_plain(v) for v in value]
    return dict(value) if isinstance(value, dict) else value


def entry_from_words(source: str, settings: Iterable[str] = ()) -> Entry:
    """What a person typed: YAML text, the path of a YAML file, the name of a battery or of a profile, and `key=value` settings for it.

    Raises `ProfileError` with one sentence.
    """
    content, values = _content(source), _settings(settings)
    if content.get("type") == "battery":
        return entry_from_dict(with_arguments(content, values))
    return entry_from_dict({**content, **values})


def _content(source: str) -> dict[str, Any]:
    if source.lstrip().startswith("{") or "\n" in source:
        content = parse(source, "the profile")
        if not isinstance(content, dict):
            raise ProfileError("a profile must be a mapping such as {type: sine, amplitude_mm: 0.3, frequency_hz: 0.5}")
        return content
    if source in battery_names():
        return read_battery(source)
    if source in entries():
        return {"type": source}
    if source.endswith((".yaml", ".yml")) or Path(source).is_file():
        return read_mapping(Path(source))
    near = get_close_matches(source, [*entries(), *battery_names()], n=1)
    hint = f"did you mean {near[0]}?" if near else "execute --list shows what there is"
    raise ProfileError(f"{source!r} is no profile, no battery and no YAML file: {hint}")


def _settings(words: Iterable[str]) -> dict[str, Any]:
    """Settings by their key. Raises `ProfileError` for a key that is given twice: nobody knows which was meant."""
    values: dict[str, Any] = {}
    for key, value in map(_setting, words):
        if key in values:
            raise ProfileError(f"{key} is given twice, as {values[key]} and as {value}: leave one out")
        values[key] = value
    return values


def _setting(word: str) -> tuple[str, Any]:
    key, equals, value = word.partition("=")
    if not equals or not key.isidentifier():
        raise ProfileError(f"{word!r} is not a setting: write key=value, such as depth_mm=0.8")
    return key, parse(value, f"the value of {key}")
