"""Random profiles of every kind, for property tests. Depths stay within 0 and 3 mm, speeds within 20 mm/s."""

from hypothesis import strategies as st

from skin_motion_profiles.catalogue import entries, entry_from_dict
from skin_motion_profiles.profile import Profile

DEEP = st.floats(0.05, 3.0)
BASE = st.floats(-1.0, 0.04)
SPEED = st.floats(0.05, 20.0)
ACCELERATION = st.floats(20.0, 900.0)
SECONDS = st.floats(0.0, 3.0)
SEED = st.integers(0, 2**31 - 1)
TURNS = st.lists(st.integers(5, 300), min_size=2, max_size=6, unique=True).map(lambda cents: [c / 100 for c in cents])
DEPTHS = st.lists(DEEP, min_size=1, max_size=3)
SPEEDS = st.lists(SPEED, min_size=1, max_size=3)

PARAMETERS = {
    "constant_rate_loops": {"depths_mm": DEPTHS, "speeds_mm_s": SPEEDS, "base_mm": BASE, "cycles": st.integers(1, 3), "rest_s": SECONDS},
    "constant_strain_hold": {"depths_mm": DEPTHS, "base_mm": BASE, "speed_mm_s": SPEED, "hold_s": SECONDS, "rest_s": SECONDS},
    "free_air": {"duration_s": st.floats(0.1, 5.0), "clearance_mm": st.floats(0.1, 3.0)},
    "hold": {"duration_s": st.floats(0.1, 5.0)},
    "minor_loops": {"depth_mm": DEEP, "returns_mm": DEPTHS, "base_mm": BASE, "speed_mm_s": SPEED},
    "multisine": {
        "seed": SEED, "amplitude_mm": st.floats(0.05, 1.0), "base_frequency_hz": st.floats(0.1, 0.5), "highest_hz": st.floats(4.0, 10.0),
        "periods": st.integers(1, 2), "falling": st.floats(0.0, 2.0), "group": st.integers(2, 4),
    },
    "ramp_list": {"depths_mm": TURNS, "speeds_mm_s": SPEEDS, "hold_s": SECONDS},
    "random_ramps": {"seed": SEED, "deepest_mm": DEEP, "shallowest_mm": BASE, "count": st.integers(1, 12), "longest_hold_s": SECONDS},
    "repeated_step": {"depth_mm": DEEP, "base_mm": BASE, "repeats": st.integers(1, 4), "speed_mm_s": SPEED, "hold_s": SECONDS},
    "sine": {
        "amplitude_mm": st.floats(0.01, 1.5), "frequency_hz": st.floats(0.05, 10.0), "offset_mm": st.none() | st.floats(0.0, 1.5),
        "periods": st.floats(0.0, 5.0), "lead_periods": st.floats(0.25, 3.0),
    },
    "stair_step": {"depth_mm": DEEP, "base_mm": BASE, "steps": st.integers(1, 8), "speed_mm_s": SPEED, "hold_s": SECONDS},
    "step": {"depth_mm": DEEP, "base_mm": BASE, "speed_mm_s": SPEED, "hold_s": SECONDS, "rest_s": SECONDS},
    "straight_line": {"by_mm": st.floats(0.01, 2.0), "speed_mm_s": SPEED},
}  # fmt: skip
_RESTLESS = {"free_air", "hold", "multisine", "sine"}  # no straight lines, hence no acceleration to choose


def contents(kind: str) -> st.SearchStrategy:
    """Mappings that describe a profile of one kind."""
    own = {"type": st.just(kind), **PARAMETERS[kind]}
    return st.fixed_dictionaries(own if kind in _RESTLESS else {**own, "acceleration_mm_s2": ACCELERATION})


def profiles() -> st.SearchStrategy:
    """Profiles of every kind."""
    return st.sampled_from(sorted(PARAMETERS)).flatmap(contents).map(entry_from_dict)


def all_profile_kinds() -> set[str]:
    """What the catalogue finds, so that a new file is not forgotten here."""
    return {kind for kind, cls in entries().items() if issubclass(cls, Profile)}
