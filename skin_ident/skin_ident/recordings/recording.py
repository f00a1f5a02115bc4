"""One session of measurement: arrays in SI units, checked once, when they are made."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from skin_ident.recordings.declared import Declared
from skin_ident.recordings.digits import digits_of
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.levels import step_of
from skin_ident.recordings.readings import Readings
from skin_ident.recordings.rows import all_finite
from skin_models.tables.order import Mended

DISPLACEMENT = "displacement"  # depth, and what it does to taxels (and to the load cell, where there is one)
MATERIAL_TEST = "material_test"  # depth and force, no taxel
FORCE_TO_FORCE = "force_to_force"  # force and taxels, no depth
TAXELS_ONLY = "taxels_only"
FEWEST = 20  # samples that a recording needs


@dataclass(frozen=True, eq=False)
class Recording:
    """One session.

    t        (N,)    s, evenly spaced unless `uneven`
    depth    (N,)    m, positive into the skin, zero at its surface; or None
    force    (N,)    N, compression positive; or None
    taxels   (T, N)  N, compression positive; T may be 0. A row whose unit is "V" is uncalibrated and holds volts
    spread   (T,)    share of the sensed force on every taxel, where the sessions of a diagnosis press at different places; or None
    steps            converter steps, m or N, of channels that were interpolated, by name (`depth`, `force`, `taxel_0`, …)
    digits           for the same channels, (N,) each: the digits of the reading nearest to every sample (`skin_ident.recordings.digits`)
    readings         readings of channels whose topic came at its own instants, by name (`skin_ident.recordings.readings`)
    mended           repairs of stamps: for every topic by itself, and for all together
    keeps_spikes     whether a fit keeps spikes instead of bridging them
    some             whether taxels were left out; then taxels with neighbouring numbers may be far apart

    `warnings` are sentences on all that was repaired, dropped or guessed, with counts. Raises `RecordingError` where the arrays do not fit
    together, are not finite, or are not evenly spaced (unless `uneven`).
    """

    name: str
    t: np.ndarray
    depth: np.ndarray | None = None
    force: np.ndarray | None = None
    taxels: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    taxel_names: tuple[str, ...] = ()
    declared: Declared = field(default_factory=Declared)
    warnings: tuple[str, ...] = ()
    taxel_units: tuple[str, ...] = ()
    uneven: bool = False
    spread: np.ndarray | None = None
    steps: Mapping[str, float] = field(default_factory=dict)
    digits: Mapping[str, np.ndarray] = field(default_factory=dict)
    readings: Mapping[str, Readings] = field(default_factory=dict)
    mended: tuple[Mended, ...] = ()
    some: bool = False
    keeps_spikes: bool = False

    def __post_init__(self) -> None:
        n = np.size(self.t)
        taxels = np.asarray(self.taxels, float)
        self._set(t=np.asarray(self.t, float), taxels=taxels if taxels.size else np.empty((len(taxels), n)))
        for channel in ("depth", "force"):
            if getattr(self, channel) is not None:
                self._set(**{channel: np.asarray(getattr(self, channel), float)})
        count = len(self.taxels)
        self._set(taxel_names=tuple(self.taxel_names) or tuple(f"taxel_{i}" for i in range(count)))
        self._set(taxel_units=tuple(self.taxel_units) or ("N",) * count)
        self._check()

    def __len__(self) -> int:
        return self.t.size

    @property
    def dt(self) -> float:
        """Sampling period, s; the mean one where stamps are uneven."""
        return (self.t[-1] - self.t[0]) / (self.t.size - 1)

    @property
    def kind(self) -> str:
        """The kind of test: one of the words at the top of this file."""
        if self.depth is not None:
            return DISPLACEMENT if len(self.taxels) else MATERIAL_TEST
        return FORCE_TO_FORCE if self.force is not None else TAXELS_ONLY

    @property
    def channels(self) -> dict[str, np.ndarray]:
        """Every measured force by the name findings use: `force`, `taxel_0`, `taxel_1`, …"""
        force = {} if self.force is None else {"force": self.force}
        return force | {f"taxel_{i}": row for i, row in enumerate(self.taxels)}

    def step(self, channel: str) -> float | None:
        """Converter step of `depth`, `force`, `taxel_0`, …, m or N; None where none is seen. For an interpolated channel it is the step
        found before interpolation, because interpolated samples are anywhere between the levels."""
        return self.steps.get(channel) or step_of(self._row(channel))

    def read(self, channel: str, part: slice = slice(None)) -> np.ndarray:
        """Digits (N,) of the readings of `depth`, `force`, `taxel_0`, …, or of a part of them: equal where readings are exactly equal."""
        if channel in self.digits:
            return self.digits[channel][part]
        return digits_of(self._row(channel)[part])

    def own(self, channel: str) -> Readings | None:
        """The readings of a channel at their own instants; None where there are none, or too few."""
        readings = self.readings.get(channel)
        return readings if readings is not None and readings.t.size >= FEWEST else None

    def with_taxels(self, rows: Sequence[int], **more: Any) -> "Recording":
        """The recording with only these taxels, in this order, with their names, units, steps, digits and readings; `more` are other fields
        to change."""
        keys = {f"taxel_{i}": f"taxel_{new}" for new, i in enumerate(rows)}

        def moved(known: Mapping[str, Any]) -> dict[str, Any]:
            kept = {name: value for name, value in known.items() if not name.startswith("taxel_")}
            return kept | {keys[name]: value for name, value in known.items() if name in keys}

        names, units = (tuple(each[i] for i in rows) for each in (self.taxel_names, self.taxel_units))
        read = dict(steps=moved(self.steps), digits=moved(self.digits), readings=moved(self.readings))
        known = dict(taxel_names=names, taxel_units=units, some=self.some or len(rows) < len(self.taxels)) | read
        return replace(self, taxels=self.taxels[list(rows)], **(known | more))

    def with_channels(self, rows: Mapping[str, np.ndarray]) -> "Recording":
        """The recording with other samples (N,) in some of `depth`, `force`, `taxel_0`, … Their readings are dropped, and so are steps and
        digits unless most samples are unchanged."""
        others = {name for name, y in rows.items() if np.mean(y == self._row(name)) <= 0.5}
        steps, digits = ({name: known for name, known in each.items() if name not in others} for each in (self.steps, self.digits))
        taxels = np.array([rows.get(f"taxel_{i}", y) for i, y in enumerate(self.taxels)]).reshape(self.taxels.shape)
        readings = {name: own for name, own in self.readings.items() if name not in rows}
        depth, force = (rows.get(name, getattr(self, name)) for name in ("depth", "force"))
        return replace(self, depth=depth, force=force, taxels=taxels, steps=steps, digits=digits, readings=readings)

    def scaled(self, factors: Mapping[str, float]) -> "Recording":
        """The recording with some of `depth`, `force`, `taxel_0`, … multiplied by factors."""
        readings = {name: own.scaled(factors.get(name, 1.0)) for name, own in self.readings.items()}
        steps = {name: step * abs(factors.get(name, 1.0)) for name, step in self.steps.items()}
        larger = self.with_channels({name: f * self._row(name) for name, f in factors.items()})
        return replace(larger, steps=steps, digits=self.digits, readings=readings)  # readings that differed still differ

    def lowered(self, zeros: Mapping[str, float]) -> "Recording":
        """The recording with constants subtracted from some of `depth`, `force`, `taxel_0`, …, in m or N."""
        readings = {name: own.lowered(zeros.get(name, 0.0)) for name, own in self.readings.items()}
        less = self.with_channels({name: self._row(name) - zero for name, zero in zeros.items()})
        return replace(less, steps=self.steps, digits=self.digits, readings=readings)

    @property
    def longest_period(self) -> float:
        """The sampling period, or the longest period of a channel's own readings where that is longer, s."""
        return max([self.dt, *(own.period for own in self.readings.values())])

    def part(self, start: int, stop: int) -> "Recording":
        """The recording cut to the samples from `start` to `stop` (exclusive)."""

        def cut(row: np.ndarray | None) -> np.ndarray | None:
            return None if row is None else row[..., start:stop]

        t, digits = cut(self.t), {name: cut(row) for name, row in self.digits.items()}
        readings = {name: own.within(t[0], t[-1]) for name, own in self.readings.items()}
        rows = dict(depth=cut(self.depth), force=cut(self.force), taxels=cut(self.taxels))
        return replace(self, t=t, digits=digits, readings=readings, **rows)

    def warned(self, *warnings: str) -> "Recording":
        """The recording with more warnings."""
        return replace(self, warnings=(*self.warnings, *warnings))

    def _row(self, channel: str) -> np.ndarray:
        return self.depth if channel == "depth" else self.channels[channel]

    def _set(self, **values: object) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def _check(self) -> None:
        n = self.t.size
        if self.t.ndim != 1 or n < FEWEST:
            raise RecordingError(f"{self.name} holds {n} usable samples; at least {FEWEST} are needed")
        steps = np.diff(self.t)
        if not (np.all(steps > 0) and (self.uneven or np.max(np.abs(steps - self.dt)) <= 1e-3 * self.dt)):
            raise RecordingError(f"{self.name} is not evenly sampled")
        if self.depth is None and self.force is None and not len(self.taxels):
            raise RecordingError(f"{self.name} has neither depth nor force nor taxels")
        for label, rows in (("depth", self.depth), ("force", self.force), ("taxels", self.taxels)):
            if rows is not None and (rows.shape[-1:] != (n,) or rows.ndim != 1 + (label == "taxels") or not all_finite(rows)):
                raise RecordingError(f"{self.name}: {label} must hold {n} finite samples")
        if len(self.taxel_units) != len(self.taxels) or len(set(self.taxel_names)) != len(self.taxels):
            raise RecordingError(f"{self.name}: every taxel needs a name of its own and a unit")
