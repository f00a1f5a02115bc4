"""What an examination of the telemetry returns."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from skin_ident.criticism.vocabulary import Key


@dataclass(frozen=True)
class Symptom:
    """A cause seen in the record itself. `bad` maps (session, channel) to a mask (N,) of samples not to be trusted; `alternatives` are
    (cause, where) that would look the same, and `apart` says what would tell them from it."""

    cause: str
    where: str
    channels: tuple[str, ...]
    parameters: dict[str, dict[str, Any]]
    evidence: dict[str, Any]
    bad: dict[tuple[str, str], np.ndarray] = field(default_factory=dict)
    alternatives: tuple[Key, ...] = ()
    apart: str = ""


def sensor_of(channel: str, n_taxels: int) -> str:
    """The name in a finding of the sensor behind a channel; a single taxel is just `taxel`."""
    if channel == "force":
        return "load_cell"
    if channel == "depth":
        return "rig"
    return "taxel" if n_taxels == 1 else channel


def quantity(value: float, unit: str) -> dict[str, Any]:
    """A parameter in the format of findings.json."""
    return {"value": float(value), "unit": unit}
