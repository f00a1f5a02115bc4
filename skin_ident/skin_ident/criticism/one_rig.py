"""One declaration for all recordings that are diagnosed together, since one model is of one skin on one rig.

Recordings of two folders may each have a `rig.yaml`. What only one of them declares holds for all. What describes skin and rig must not
differ. Steps, noise and uncertainties may, as where a range was switched: then the largest is expected everywhere, and a warning says so.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.usable import warned_first
from skin_ident.recordings.declared import FILE_NAME

OF_THE_RIG = ("skin_thickness_mm", "moving_mass_kg", "spread_width_mm", "taxel_positions_mm")
LARGEST_COUNTS = (
    "force_step_n",
    "taxel_step_n",
    "encoder_step_um",
    "encoder_noise_um",
    "force_noise_n",
    "taxel_noise_n",
    "taxel_gain_uncertainty",
)
PLACED = "taxel_positions_mm"  # not passed on: a recording without it does not say where it presses either


def of_one_rig(recordings: list) -> list:
    """The recordings with the declaration that they share; each keeps its own contact position. Raises `DiagnosisError` where two of them
    declare a different skin or rig."""
    common, warnings = {}, []
    for key in (*OF_THE_RIG, *LARGEST_COUNTS):
        said_of = _values(recordings, key)
        if len(said_of) > 1:
            (one, first), (other, second) = list(said_of.items())[:2]
            differs = f"{FILE_NAME} declares {key} {_written(one)} for {first} and {_written(other)} for {second}"
            if key in OF_THE_RIG:
                raise DiagnosisError(f"{differs}, and a model is of one skin on one rig: correct it, or diagnose them separately")
            warnings.append(f"{differs}: the largest is expected in every session")
        if said_of and key != PLACED:
            common[key] = _largest([*said_of])
    return warned_first([replace(r, declared=replace(r.declared, **common)) for r in recordings], warnings)


def _values(recordings: list, key: str) -> dict:
    """The different values that recordings declare, each with the name of the first that does."""
    found = {}
    for r in recordings:
        value = getattr(r.declared, key)
        if value not in (None, ()):
            found.setdefault(value, r.name)
    return found


def _largest(values: list):
    """The largest of numbers, or of tuples of one number for all taxels or one for each."""
    if not isinstance(values[0], tuple):
        return max(values)
    return tuple(float(x) for x in np.max(np.broadcast_arrays(*values), axis=0))


def _written(value) -> str:
    return f"[{', '.join(map(_written, value))}]" if isinstance(value, tuple) else f"{value:g}"
