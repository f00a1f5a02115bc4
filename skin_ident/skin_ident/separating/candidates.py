"""Motions that might tell causes apart: profiles at several speeds and amplitudes, and the shipped batteries.

Every candidate begins and ends in free air, so that it can be recorded as a session of its own.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from math import floor
from typing import Any

import yaml

from skin_ident.separating.path import planned, within
from skin_models.signals import Motion
from skin_motion_profiles.battery_file import battery_names
from skin_motion_profiles.catalogue import entry_from_dict
from skin_motion_profiles.errors import ProfileError
from skin_motion_profiles.profile_file import entry_from_words, entry_to_text

LONGEST = 120.0  # s, longest candidate
BRISK = 500.0  # mm/s^2, acceleration of the profiles
GENTLE = 1.0  # mm/s: only loops up to this speed cross the surface; faster, the jump at contact is taken for a spike, or left out
BATTERIES = ("demo", "full", "hysteresis_and_rate", "relaxation", "stiffness", "sinusoidal_identification", "pseudo_random_validation")
AIR = {"type": "free_air", "duration_s": 1.5}
SECOND_DRAW = 1000  # added to the seeds of a battery that is recorded again, so that no candidate has the same seed
RICH = ("demo", "full", "pseudo_random_validation")  # batteries that do not repeat themselves (see `Candidate`)


@dataclass(frozen=True)
class Candidate:
    """A battery: its name, the YAML text that the profile server runs, and the motion that results.

    `rich` says that the motion does not repeat itself. From periodic motion alone, noise cannot be told from an effect of the same period.
    """

    name: str
    text: str
    motion: Motion
    rich: bool

    @property
    def seconds(self) -> float:
        """Duration, s."""
        return len(self.motion) * self.motion.dt


def candidates(deepest: float, dt: float, seed: int = 0) -> list[Candidate]:
    """Every candidate that goes no deeper than `deepest` (m), lasts no more than LONGEST and is within the rig's limits, sampled every `dt`
    s; `seed` is that of random motions."""
    found = []
    for name, content, rich in _described(_rounded(deepest * 1e3), seed):
        try:
            entry = entry_from_dict(content)
            motion = planned(entry, dt, within(deepest + 2e-6))
        except ProfileError:
            continue  # impossible at this depth, or not a single motion
        if len(motion) * dt <= LONGEST:
            found.append(Candidate(name, entry_to_text(entry), motion, rich))
    return found


def random_motion(deepest: float) -> str:
    """YAML text of a battery of quick loops, a multisine and random ramps up to `deepest` (m). It takes half the time of the battery
    `full`, shows a little of everything, and reaches the largest loads."""
    d = _rounded(deepest * 1e3)
    profiles = [AIR, _quick_loops(d), _multisine(d, 0.4, 0) | {"periods": 1}, _random_ramps(d, 8, 0), dict(AIR)]
    return yaml.safe_dump({"type": "battery", "name": "random motion", "profiles": profiles}, sort_keys=False, width=140)


def redrawn(battery: str) -> str:
    """A battery (YAML or name) with other seeds of its random motions, as YAML. A battery without random motions is returned unchanged.
    Raises `ProfileError`."""
    content = yaml.safe_load(entry_to_text(entry_from_words(battery)))
    other = _reseeded(content)
    return battery if other == content else yaml.safe_dump(other, sort_keys=False, allow_unicode=True, width=140)


def _reseeded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: v + SECOND_DRAW if key == "seed" else _reseeded(v) for key, v in value.items()}
    return [_reseeded(v) for v in value] if isinstance(value, list) else value


def _rounded(d: float) -> float:
    """A depth `d` (mm) rounded down to hundredths of a mm, as a person would type it; depths up to 0.1 mm are not rounded."""
    return floor(d * 100.0 + 0.2) / 100.0 if d > 0.1 else d


def _described(d: float, seed: int) -> Iterator[tuple[str, dict[str, Any], bool]]:
    """Name and content of every candidate for a depth of `d` mm, and whether it is rich."""
    for profiles, rich in (((*_sines(d), *_loops(d), *_rests(d)), False), (_rich(d, seed), True)):
        for name, profile in profiles:
            yield name, {"type": "battery", "profiles": [AIR, profile, AIR]}, rich
    for name in sorted(set(BATTERIES) & set(battery_names())):
        yield f"the battery {name}", {"battery": name, "depth_mm": d}, name in RICH


def _sines(d: float) -> Iterator[tuple[str, dict[str, Any]]]:
    for share in (0.2, 0.45):
        for f in (0.2, 0.5, 1.0, 2.0, 4.0, 7.0):
            yield (
                f"a sine of {share * d:.2g} mm at {f:g} Hz",
                {"type": "sine", "amplitude_mm": share * d, "offset_mm": 0.5 * d, "frequency_hz": f, "periods": max(2.0, 3.0 * f)},
            )
    yield "a sine of 0.5 mm at 3 Hz in the air", {"type": "sine", "amplitude_mm": 0.5, "offset_mm": -1.5, "frequency_hz": 3, "periods": 12}


def _loops(d: float) -> Iterator[tuple[str, dict[str, Any]]]:
    common = {"type": "constant_rate_loops", "acceleration_mm_s2": BRISK}
    for pace in (0.2, 0.5, 1.0, 3.0, 10.0):
        base = -0.1 if pace <= GENTLE else 0.1 * d
        yield f"triangles to {d:g} mm at {pace:g} mm/s", {**common, "base_mm": base, "depths_mm": d, "speeds_mm_s": pace, "cycles": 3}
    slow = {**_quick_loops(d), "base_mm": -0.1, "speeds_mm_s": 0.5, "cycles": 2}
    yield "triangles of three depths at 0.5 mm/s", slow
    yield "triangles of three depths at 10 mm/s", _quick_loops(d)
    yield "small triangles at 0.1 and 1 mm/s", {**common, "base_mm": 0.5 * d, "depths_mm": 0.65 * d, "speeds_mm_s": [0.1, 1], "cycles": 2}
    yield "a slow approach", {**common, "base_mm": -0.3, "depths_mm": 0.3 * d, "speeds_mm_s": 0.2, "cycles": 2}
    for pace in (0.5, 2.0, 8.0):
        returns = [0.7 * d, 0.35 * d]
        minor = {"type": "minor_loops", "depth_mm": d, "returns_mm": returns, "speed_mm_s": pace, "acceleration_mm_s2": BRISK}
        yield f"minor loops at {pace:g} mm/s", minor


def _rests(d: float) -> Iterator[tuple[str, dict[str, Any]]]:
    for seconds in (2.0, 6.0, 15.0):
        hold = {"type": "constant_strain_hold", "depths_mm": [0.5 * d, d], "hold_s": seconds, "rest_s": 0.5 * seconds}
        yield f"holds of {seconds:g} s at two depths", {**hold, "acceleration_mm_s2": BRISK}
    yield "a stair of holds down and up", {
        "type": "ramp_list", "depths_mm": [0.0, 0.25 * d, 0.5 * d, 0.75 * d, d, 0.75 * d, 0.5 * d, 0.25 * d, 0.0],
        "speeds_mm_s": 5, "hold_s": 2.0, "acceleration_mm_s2": BRISK,
    }  # fmt: skip
    yield "a long wait in the air", {"type": "free_air", "duration_s": 12.0}


def _quick_loops(d: float) -> dict[str, Any]:
    deep, common = [0.4 * d, 0.7 * d, d], {"type": "constant_rate_loops", "acceleration_mm_s2": BRISK}
    return {**common, "base_mm": 0.1 * d, "depths_mm": deep, "speeds_mm_s": 10, "cycles": 3}


def _rich(d: float, seed: int) -> Iterator[tuple[str, dict[str, Any]]]:
    for share in (0.15, 0.4):
        yield f"a multisine of {share * d:.2g} mm up to 8 Hz", _multisine(d, share, seed)
    for fastest in (2, 8):
        yield f"random ramps at {fastest} mm/s at most", _random_ramps(d, fastest, seed)


def _multisine(d: float, share: float, seed: int) -> dict[str, Any]:
    sines = {"type": "multisine", "seed": seed, "offset_mm": 0.5 * d, "base_frequency_hz": 0.25, "highest_hz": 8}
    return {**sines, "amplitude_mm": share * d}


def _random_ramps(d: float, fastest: float, seed: int) -> dict[str, Any]:
    ramps = {"type": "random_ramps", "seed": seed, "deepest_mm": d, "slowest_mm_s": 0.2, "fastest_mm_s": fastest, "count": 16}
    return {**ramps, "acceleration_mm_s2": BRISK}
