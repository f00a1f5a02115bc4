"""What a diagnosis hands to the report: the content of findings.json and the curves behind it."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Trace:
    """One session as measured and as simulated, at full rate: arrays (N,) and, by channel, (C, N); N, m, m/s."""

    session: str
    held_out: bool
    t: np.ndarray
    depth: np.ndarray
    speed: np.ndarray
    channels: tuple[str, ...]
    measured: np.ndarray
    baseline: np.ndarray
    extended: np.ndarray
    left_out: np.ndarray | None = None  # (N,), 1 where a sample was not compared

    @property
    def compared(self) -> np.ndarray:
        """Mask (N,) of the samples that were compared."""
        return np.ones(self.t.size, bool) if self.left_out is None else np.asarray(self.left_out) < 0.5


@dataclass(frozen=True)
class ScanTrace:
    """One spread scan: depth (D,) m, distance (R,) m, force (D, R) N, measured and simulated before and after."""

    session: str
    depth: np.ndarray
    distance: np.ndarray
    measured: np.ndarray
    baseline: np.ndarray
    extended: np.ndarray


@dataclass(frozen=True)
class Round:
    """One round of the search: (cause, where, gain in squared whitened units) of all ranked causes, best first, and the cause that was
    named."""

    ranked: tuple[tuple[str, str, float], ...]
    named: str | None


@dataclass(frozen=True)
class Outcome:
    """The result of a diagnosis. `findings` is what findings.json holds (schema 1); `model` is the extended model and `baseline` what it
    started from (None for a spread scan without one). `batteries` are the separating experiments: YAML text by file name."""

    findings: dict[str, Any]
    baseline: Any = None
    model: Any = None
    std: dict[str, float] = field(default_factory=dict)
    traces: tuple[Trace, ...] = ()
    scans: tuple[ScanTrace, ...] = ()
    rounds: tuple[Round, ...] = ()
    batteries: dict[str, str] = field(default_factory=dict)
