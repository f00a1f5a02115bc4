"""What is known about a rig beforehand: `rig.yaml` beside the recordings, every entry optional.

    sample_rate_hz: 100
    force_step_n: 0.0678          # one step of the load cell's converter
    taxel_step_n: 0.107           # one number for all, or a list
    encoder_step_um: 0.1
    encoder_noise_um: 1.5         # standard deviation of the noise of its readings, beside the rounding to steps
    plunger_diameter_mm: 9.9      # kept for other programs: nothing here reads it
    taxel_positions_mm: [[0, 0], [14, 0]]
    contact_position_mm: [0, 0]   # where the plunger presses, in the same frame; or by recording: {session_0: [0, 0], session_1: [5, 0]}
    spread_width_mm: 5.25         # c of exp(-(r / c)^2), if a lateral scan of this skin was made; new scans are compared with it
    taxel_gain_uncertainty: 0.03  # relative standard error of every taxel's calibration
    skin_thickness_mm: 4
    moving_mass_kg: 0.000432      # what moves between load cell and skin
    force_noise_n: 0.03           # standard deviation of the load cell's noise, of any colour
    taxel_noise_n: 0.03
    calibration:                  # for columns or topics in volts: force = slope * (voltage - zero)
      ai0: {channel: force, slope_n_per_v: -4.1448, zero_v: -0.072}
      taxel_0: {slope_n_per_v: 9.4}

Static scans beside one `rig.yaml` are taken to be of one taxel under one skin, unless `contact_position_mm` gives them different places.

Unknown keys are ignored with a warning, because the file may serve other programs too.
"""

import os
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from difflib import get_close_matches
from math import dist
from pathlib import Path
from typing import Any

import yaml

from skin_ident.recordings.errors import RecordingError
from skin_models.errors import ModelError
from skin_models.strict_yaml import load_yaml
from skin_models.words import counted

FILE_NAME = "rig.yaml"
PER_TAXEL = ("taxel_step_n", "taxel_noise_n")  # one number for all taxels, or one for each
STEPS_AND_NOISE = ("force_step_n", "encoder_step_um", "encoder_noise_um", "force_noise_n", *PER_TAXEL)  # no reading has none of either
POSITIONS = "taxel_positions_mm"
LARGEST = {  # values above which the unit must be wrong
    "sample_rate_hz": 1e6,
    "encoder_step_um": 1e4,
    "encoder_noise_um": 1e4,
    "plunger_diameter_mm": 1e3,
    "skin_thickness_mm": 1e3,
    "moving_mass_kg": 100.0,
    "spread_width_mm": 1e3,
    "taxel_gain_uncertainty": 1.0,
}
LEAST = {"plunger_diameter_mm": 0.05, "skin_thickness_mm": 0.02, "spread_width_mm": 0.02}  # values below which it must be wrong, too
CLOSEST_MM = 0.1  # mm between the first taxel and the next: no skin has them closer, but places in metres look so
THICK_MM = 50.0  # mm: a warning is given for thicker skin


@dataclass(frozen=True)
class Calibration:
    """A straight line from volts to newtons. `channel` is what the column means (force, taxel_<name>); empty: the column's own name.

    `zero_v` is the voltage without load; None takes the median of the first second that holds numbers.
    """

    slope_n_per_v: float
    zero_v: float | None = None
    channel: str = ""


@dataclass(frozen=True)
class Declared:
    """Everything `rig.yaml` may declare. None or empty means unknown."""

    sample_rate_hz: float | None = None
    force_step_n: float | None = None
    taxel_step_n: tuple[float, ...] = ()
    encoder_step_um: float | None = None
    encoder_noise_um: float | None = None
    plunger_diameter_mm: float | None = None
    skin_thickness_mm: float | None = None
    moving_mass_kg: float | None = None
    force_noise_n: float | None = None
    taxel_noise_n: tuple[float, ...] = ()
    taxel_positions_mm: tuple[tuple[float, float], ...] = ()
    contact_position_mm: Mapping[str, tuple[float, float]] = field(default_factory=dict, hash=False)  # by recording; "": all of them
    spread_width_mm: float | None = None
    taxel_gain_uncertainty: float | None = None
    calibration: Mapping[str, Calibration] = field(default_factory=dict, hash=False)
    warnings: tuple[str, ...] = ()

    @property
    def encoder_step(self) -> float:
        """The step of the encoder, m; 0 where none is declared."""
        return 1e-6 * (self.encoder_step_um or 0.0)

    def of_taxel(self, key: str, i: int) -> float | None:
        """The value of a per-taxel entry for taxel `i`; None where nothing is declared."""
        values = getattr(self, key)
        return values[0] if len(values) == 1 else values[i] if i < len(values) else None

    def checked_for(self, taxels: int) -> "Declared":
        """The declaration itself, checked for a recording of so many taxels. Raises `RecordingError` where a list has another length."""
        for key in (*PER_TAXEL, POSITIONS):
            said = len(getattr(self, key))
            if taxels and said not in (0, taxels) and not (said == 1 and key in PER_TAXEL):
                what, each = ("position", "[x, y] for each") if key == POSITIONS else ("number", "one number for all, or one for each")
                raise RecordingError(
                    f"{key} in {FILE_NAME} has {counted(said, what)}, but the recording has {counted(taxels, 'taxel')}: give {each}"
                )
        return self

    def contact_of(self, recording: str) -> tuple[float, float]:
        """Where the plunger presses in a recording, mm; the origin of the taxels' frame unless it is declared otherwise.

        A recording is identified by its file name, with or without the suffix.
        """
        places = self.contact_position_mm
        return next((places[name] for name in (recording, Path(recording).stem, "") if name in places), (0.0, 0.0))

    def of(self, recording: str) -> "Declared":
        """The declaration for one recording: with only its own contact position, and a warning where only other recordings have one."""
        if not self.contact_position_mm:
            return self
        place = {"": self.contact_of(recording)}
        if {"", recording, Path(recording).stem} & set(self.contact_position_mm):
            return replace(self, contact_position_mm=place)
        others = ", ".join(self.contact_position_mm)
        said = f"contact_position_mm says where other recordings press ({others}), not this one: it is taken to press at [0, 0]"
        return replace(self, contact_position_mm=place, warnings=(*self.warnings, said))

    def filled_with(self, other: "Declared") -> "Declared":
        """The declaration with unknown values taken from `other`."""
        unknown = [f.name for f in fields(self) if getattr(self, f.name) in (None, (), {})]
        return replace(self, **{name: getattr(other, name) for name in unknown})


def declared_beside(path: Path) -> Declared:
    """The declaration for `path` in the `rig.yaml` that `rig_file` finds; an empty one where there is none. Raises `RecordingError`, also
    for a folder of that name."""
    file = rig_file(path)
    return Declared() if file is None else read_declared(file).of(path.name)


def rig_file(path: Path) -> Path | None:
    """The `rig.yaml` in the folder of `path`, or in `path` itself where that is a folder; None where there is none."""
    folders = (path, path.parent) if path.is_dir() else (path.parent,)
    return next((folder / FILE_NAME for folder in folders if os.path.lexists(folder / FILE_NAME)), None)


def read_declared(path: Path) -> Declared:
    """The content of a `rig.yaml`. Unknown keys become a warning. Raises `RecordingError` for a value that is no positive
    number, a name that stands twice, or text that is no YAML."""
    try:
        return declared_from(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise RecordingError(f"cannot read {path}: {getattr(error, 'strerror', None) or 'it is not UTF-8 text'}") from error
    except RecordingError as error:
        raise RecordingError(f"{path}: {error}") from error


def declared_from(text: str) -> Declared:
    """The same from the file's text. Raises `RecordingError`."""
    try:
        content = load_yaml(text)
    except yaml.YAMLError as error:
        raise RecordingError(f"this is not YAML: {' '.join(str(error).split())}") from error
    except ModelError as error:
        raise RecordingError(str(error)) from error
    content = _mapping({} if content is None else content, "a rig description")
    naught = [key for key in STEPS_AND_NOISE if _is_naught(content.get(key))]
    content = {key: value for key, value in content.items() if key not in naught}
    known = [f.name for f in fields(Declared) if f.name != "warnings"]
    numbers = [key for key in known if key not in (*PER_TAXEL, POSITIONS, "contact_position_mm", "calibration")]
    return Declared(
        **{key: _positive(key, content[key]) for key in numbers if key in content},
        **{key: _per_taxel(key, content[key]) for key in PER_TAXEL if key in content},
        warnings=(*_warnings(content, known), *(f"{key} in {FILE_NAME} is 0, which no reading has: taken as unknown" for key in naught)),
        taxel_positions_mm=_positions(content.get(POSITIONS, [])),
        contact_position_mm=_contacts(content.get("contact_position_mm", {})),
        calibration={str(k): _calibration(str(k), v) for k, v in _mapping(content.get("calibration", {}), "calibration").items()},
    )


def _is_naught(value: Any) -> bool:
    """Whether a value is zero, or a list of zeros."""
    values = value if isinstance(value, list) else [value]
    return bool(values) and all(isinstance(v, (int, float)) and not isinstance(v, bool) and v == 0 for v in values)


def _warnings(content: Mapping[str, Any], known: list[str]) -> Iterator[str]:
    """Warnings about unknown keys and implausible values."""
    unknown = sorted(str(key) for key in content if key not in known)
    if unknown:
        yield f"ignored in {FILE_NAME}, unknown: {', '.join(_or_meant(key, known) for key in unknown)}"
    thick = content.get("skin_thickness_mm")
    if thick is not None and thick > THICK_MM:
        yield f"skin_thickness_mm in {FILE_NAME} is {thick:g}: skin is hardly ever thicker than {THICK_MM:g} mm, is it in millimetres?"


def _or_meant(key: str, known: list[str]) -> str:
    """An unknown key, with the known key that it resembles, if any."""
    near = get_close_matches(key, known, 1)
    return f"{key} (is {near[0]} meant?)" if near else key


def _calibration(name: str, entry: Any) -> Calibration:
    entry = _mapping(entry, f"calibration of {name}")
    _only(entry, [f.name for f in fields(Calibration)], f"calibration of {name}")
    if "slope_n_per_v" not in entry:
        raise RecordingError(f"calibration of {name} needs slope_n_per_v")
    slope = _number(f"{name}.slope_n_per_v", entry["slope_n_per_v"])
    if slope == 0.0:
        raise RecordingError(f"calibration of {name}: slope_n_per_v must not be zero")
    zero = entry.get("zero_v")
    return Calibration(slope, None if zero is None else _number(f"{name}.zero_v", zero), str(entry.get("channel", "")))


def _positions(entries: Any) -> tuple[tuple[float, float], ...]:
    if not isinstance(entries, list):
        raise RecordingError(f"{POSITIONS} must be a list: one [x, y], or one number for a row of taxels, per taxel")
    places = tuple(_position(entry) for entry in entries)
    if len(set(places)) < len(places):
        raise RecordingError(f"{POSITIONS}: two taxels are at the same place")
    apart = min((dist(places[0], place) for place in places[1:]), default=CLOSEST_MM)
    if apart < CLOSEST_MM:
        raise RecordingError(f"{POSITIONS}: taxels are only {apart:g} mm apart: are their places in millimetres?")
    return places


def _contacts(entry: Any) -> dict[str, tuple[float, float]]:
    if isinstance(entry, Mapping):
        return {str(name): _position(place, "contact_position_mm") for name, place in entry.items()}
    if isinstance(entry, list) and any(isinstance(place, list) for place in entry):
        raise RecordingError("contact_position_mm: of several places name the recordings, as in {session_1: [0, 0], session_2: [5, 0]}")
    return {"": _position(entry, "contact_position_mm")}


def _position(entry: Any, key: str = POSITIONS) -> tuple[float, float]:
    pair = entry if isinstance(entry, list) else [entry, 0.0]
    if len(pair) not in (2, 3):
        raise RecordingError(f"{key}: {entry!r} is neither a number nor [x, y]")
    return _number(key, pair[0]), _number(key, pair[1])


def _per_taxel(key: str, value: Any) -> tuple[float, ...]:
    if isinstance(value, list) and None in value:
        raise RecordingError(f"{key}: taxel {value.index(None)} has no value: give every taxel a number, or leave {key} out")
    entries = value if isinstance(value, list) else [] if value is None else [value]
    return tuple(_positive(key, entry) for entry in entries)


def _positive(key: str, value: Any) -> float | None:
    number = None if value is None else _number(key, value)
    if number is not None and number <= 0.0:
        raise RecordingError(f"{key} must be positive, not {value!r}")
    if number is not None and number < LEAST.get(key, 0.0):
        raise RecordingError(f"{key} cannot be less than {LEAST[key]:g}, and is {value!r}: is it in the unit that its name says?")
    if number is not None and number > LARGEST.get(key, float("inf")):
        raise RecordingError(f"{key} cannot be more than {LARGEST[key]:g}, and is {value!r}: is it in the unit that its name says?")
    return number


def _number(key: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not abs(value) <= sys.float_info.max:
        raise RecordingError(f"{key} must be a number, not {value!r}")
    return float(value)


def _mapping(thing: Any, label: str) -> dict:
    if not isinstance(thing, Mapping):
        raise RecordingError(f"{label} must be a mapping of names to values")
    return dict(thing)


def _only(entries: Mapping, known: list[str], label: str) -> None:
    unknown = sorted(set(map(str, entries)) - set(known))
    if unknown:
        raise RecordingError(f"{label} has an unknown entry {unknown[0]!r}; known are {', '.join(known)}")
