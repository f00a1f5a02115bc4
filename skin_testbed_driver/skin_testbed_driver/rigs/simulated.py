"""The thesis's testbed in simulation: stage, load cell and taxels around a specimen of `skin_models`, with any hidden effects.

Stage (Newport UTMCC1HL, thesis section 3.1): 150 mm of travel, 20 mm/s, encoder of 1 um. It goes from set point to set point by a cubic
and comes to rest 1 to 5 um beside where it should, which the encoder shows; its screw is true to 5 um over the travel, which the encoder
does not show. An x-y stage brings other points of the skin under the plunger; what a taxel beside it senses falls as the model's spread
says, by default the thesis's Gaussian (section 4.3.4). Mounting plate and load cell are a spring between encoder and plunger. Load cell
and taxels are volts behind a 12-bit converter of +-10 V (NI 9201); the taxels' conditioner ends at 0 and 5 V.
"""

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_models.bare import BareSkin, is_bare
from skin_models.dispersion import Dispersion
from skin_models.layout import Layout, row_from_origin
from skin_models.model import Model, Response
from skin_models.signals import Sample
from skin_testbed_driver.calibration import Calibration
from skin_testbed_driver.rig import NOTHING, Reading, Rig

TRAVEL = (0.0, 0.15)  # m
ENCODER_STEP = 1e-6  # m
CONVERTER_STEP = 20.0 / 4096  # V
CONVERTER_RANGE = (-2048, 2047)  # counts
TAXEL_RANGE = (0.0, 5.0)  # V, of the conditioner
_TAXEL_COUNTS = (TAXEL_RANGE[0] / CONVERTER_STEP, TAXEL_RANGE[1] / CONVERTER_STEP)
_BATCH = 512  # numbers of noise that are drawn at once: few enough that no sample waits for them
_SCREW = 2.0 * math.pi / 0.04  # rad/m, of the screw's error: one turn in 40 mm
_SETTLING = 0.2  # s, time constant with which the servo error dies away or sets in
_STILL = 1e-9  # m/s
_BENT = 1e-10  # m, accuracy with which the bend of the mount is found
_TRIES = 6
_LATERAL_SPEED = 0.01  # m/s, of the x-y stage
PLUNGER_DIAMETER = 9.9e-3  # m


@dataclass(frozen=True)
class Imperfections:
    """What makes the hardware real. V are standard deviations of white noise; the others are sizes in m. All zero is an ideal rig."""

    load_cell_noise: float = 3e-3  # V
    taxel_noise: float = 3e-3  # V
    rest_error: float = 5e-6  # m, greatest; the least is a fifth of it
    screw_error: float = 2.5e-6  # m, amplitude over the travel
    quantised: bool = True
    # m/N, of mounting plate and load cell. The thesis's specimens were identified by this rig's encoder: their softness includes its own,
    # so 0 gives what the thesis measured. Plunger on bare taxel gave 226 kN/m (Table 3-2), hence 4.4e-6 m/N at most.
    mount_compliance: float = 0.0


class SimulatedRig(Rig):
    """A `Model` on the thesis's hardware. Every `read` is one sample period after the last, in simulated time."""

    owns_time = True
    travel = TRAVEL

    def __init__(
        self,
        model: Model,
        calibration: Calibration,
        layout: Layout | None = None,
        surface: float = 0.075,
        start: float = 0.073,
        seed: int = 0,
        imperfections: Imperfections | None = None,
    ) -> None:
        """`surface` and `start` are stage positions (m) of the skin and of the plunger; `calibration` is the true one.

        The model's shares are those with the plunger at the origin of the skin's frame.
        """
        self.layout = layout or row_from_origin(len(model.shares))
        self._model = replace(model, positions=tuple(map(tuple, self.layout.positions[:, :2].tolist())))
        self._slopes, self._load_cell_slope = calibration.taxels, calibration.load_cell
        self._surface, self._seed, self._real = surface, seed, imperfections or Imperfections()
        self._start = start
        self._noise = np.array([self._real.load_cell_noise] + len(self.layout) * [self._real.taxel_noise]) / CONVERTER_STEP
        # Taxels that are as loud as this may leave the converter's range, which is twice the conditioner's.
        self._loud = self._real.taxel_noise > 0.1  # V
        self._counts = np.empty(self._noise.size)  # what the converter sees, in its steps, the load cell first

    def open(self, sample_rate: float) -> None:
        """Begin at rest at `start`, at `sample_rate` (Hz); the seed decides about everything random."""
        self._dt = 1.0 / sample_rate
        self._rng, self._noise_rng = np.random.default_rng(self._seed), np.random.default_rng([self._seed, 1])
        self._screw_phase = self._rng.uniform(0.0, 2.0 * math.pi)
        self._state = self._model.initial(self._seed)
        self._x, self._v, self._a = self._start, 0.0, 0.0  # wanted by the servo
        self._error, self._rest_error = 0.0, 0.0  # of the servo
        self._next = (self._x, self._v)
        self._error_speed = 0.0
        self._time = 0.0
        skin, self._bend = self._model.dispersion, 0.0
        self._steepness = skin.k1 + skin.k2 + (skin.b1 + skin.b2) / self._dt  # N/m, of the force over the depth of one sample
        self._xy = self._xy_target = (0.0, 0.0)
        self._fade = math.exp(-self._dt / _SETTLING)
        self._bare = BareSkin(self._model, self._dt) if is_bare(self._model) and not self._real.mount_compliance else None
        self._batch = np.empty((max(_BATCH // self._noise.size, 1), self._noise.size))
        self._drawn = len(self._batch)
        self._ahead: Reading | None = None
        self._look_around()

    def command(self, position: float, velocity: float) -> None:
        """Be at `position` (m), kept within the travel, with `velocity` (m/s) at the next sample."""
        self._next = (min(max(position, self.travel[0]), self.travel[1]), velocity)

    def halt(self) -> None:
        """Stand still at once, where the servo is."""
        self._next = (self._x, 0.0)

    def place(self, x: float, y: float) -> None:
        """Let the x-y stage go to (x, y) m at 10 mm/s, in a straight line."""
        self._xy_target = (x, y)

    def placed(self) -> tuple[float, float]:
        """The point (m) that the x-y stage has brought under the plunger."""
        return self._xy

    def facts(self) -> dict[str, Any]:
        """Diameter of the plunger, and where quantised the steps of encoder (um), load cell and taxels (N)."""
        facts = {"plunger_diameter_mm": 1e3 * PLUNGER_DIAMETER}
        if self._real.quantised:
            facts["encoder_step_um"] = 1e6 * ENCODER_STEP
            facts["force_step_n"] = CONVERTER_STEP * self._load_cell_slope
            facts["taxel_step_n"] = (CONVERTER_STEP * self._slopes).tolist()
        return facts

    def read(self) -> Reading:
        """One period later: where the encoder says the stage is (m), what load cell and taxels say (V), and both truths (N)."""
        reading, self._ahead = self._ahead or self._step(), None
        return reading

    def prepare(self) -> None:
        """Go to the next reading now."""
        self._ahead = self._ahead or self._step()

    def _step(self) -> Reading:
        self._move()
        x, v = self._tip()
        if self._xy != self._xy_target:
            self._move_laterally()
        if self._bare is None:
            volts, force_truth, truth = self._response(x, v)
        else:
            force_truth, sensed = self._bare.press(x, v, self._a)
            truth = self._shares * sensed
            np.multiply(self._gains, sensed, self._counts)
            volts = self._volts(force_truth, 0.0 <= sensed * self._greatest_gain <= _TAXEL_COUNTS[1])
        self._time += self._dt
        return Reading(self._encoder(self._x + self._error), float(volts[0]), math.nan, volts[1:], NOTHING, force_truth, truth)

    def _response(self, x: float, v: float) -> tuple[np.ndarray, float, np.ndarray]:
        """Volts and both truths for a model with effects."""
        response = self._press(x, v)
        np.divide(response.taxels, self._slopes * CONVERTER_STEP, self._counts[1:])
        return self._volts(float(response.force), False), float(response.force_truth), response.taxels_truth

    def _press(self, x: float, v: float) -> Response:
        """The skin's answer to a mount at depth `x` (m): the plunger's face is at x - C F, found by Newton's method."""
        compliance, dt, before = self._real.mount_compliance, self._dt, self._bend
        lateral = np.array(self._xy) if any(self._xy) else None
        for _ in range(_TRIES):
            sample = Sample(self._time, x - self._bend, v - (self._bend - before) / dt, self._a, lateral)
            state, response = self._model.step(self._state, sample, dt)
            force = float(response.force_truth)
            miss = self._bend - compliance * force
            if abs(miss) < _BENT:
                break
            self._bend = self._bend - miss / (1.0 + compliance * self._steepness) if force > 0.0 else 0.0
        self._state, self._bend = state, x - sample.x
        return response

    def _move(self) -> None:
        """One period along the cubic to the set point, and the servo's error with it."""
        (x0, v0), (x1, v1), h = (self._x, self._v), self._next, self._dt
        self._a = 6.0 * (x0 - x1) / h**2 + (2.0 * v0 + 4.0 * v1) / h
        came_to_rest = abs(v1) < _STILL and x0 == x1 and self._rest_error == 0.0 and self._time > 0.0
        if x0 != x1:
            self._rest_error = 0.0
        elif came_to_rest:
            size = self._rng.uniform(0.2, 1.0) * self._real.rest_error
            self._rest_error = size if self._rng.random() < 0.5 else -size
        self._error = self._rest_error + self._fade * (self._error - self._rest_error)
        self._error_speed = (self._rest_error - self._error) / _SETTLING
        self._x, self._v = x1, v1

    def _move_laterally(self) -> None:
        """One period towards the place asked for."""
        (x, y), (to_x, to_y) = self._xy, self._xy_target
        step = min(1.0, _LATERAL_SPEED * self._dt / math.hypot(to_x - x, to_y - y))
        self._xy = (x + (to_x - x) * step, y + (to_y - y) * step)
        self._look_around()

    def _look_around(self) -> None:
        """For a bare skin, update the taxels' shares of the sensed force where the plunger is, (T,), and in converter steps/N, (1 + T,)."""
        if self._bare is None:
            return
        self._shares = self._shares_here()
        self._gains = np.concatenate([[0.0], self._shares / (self._slopes * CONVERTER_STEP)])
        self._greatest_gain = float(self._gains.max())

    def _shares_here(self) -> np.ndarray:
        """Each taxel's share of the sensed force, (T,), where the plunger is: the response of a skin of 1 N/m to a depth of 1 m."""
        unit = replace(self._model, dispersion=Dispersion(k1=1.0, b1=0.0, k2=0.0, b2=0.0, m=0.0))
        sample = Sample(0.0, 1.0, 0.0, 0.0, np.array(self._xy) if any(self._xy) else None)
        return unit.step(unit.initial(), sample, self._dt)[1].taxels_truth

    def _tip(self) -> tuple[float, float]:
        """Depth (m) and speed (m/s) of the plunger's face: the servo's position with the screw's error."""
        phase = _SCREW * self._x + self._screw_phase
        position = self._x + self._error + self._real.screw_error * math.sin(phase)
        slope = 1.0 + self._real.screw_error * _SCREW * math.cos(phase)
        return position - self._surface, (self._v + self._error_speed) * slope

    def _encoder(self, position: float) -> float:
        return round(position / ENCODER_STEP) * ENCODER_STEP if self._real.quantised else position

    def _volts(self, force: float, within: bool) -> np.ndarray:
        """What the converter says, load cell first: (1 + T,). `within`: no taxel is beyond the range of its conditioner."""
        counts = self._counts
        if not within:
            np.minimum(np.maximum(counts, _TAXEL_COUNTS[0], counts), _TAXEL_COUNTS[1], counts)
        counts[0] = cell = force / (self._load_cell_slope * CONVERTER_STEP)
        counts += self._white()
        if not self._real.quantised:
            return counts * CONVERTER_STEP
        np.rint(counts, counts)
        if self._loud or abs(cell) > 0.9 * CONVERTER_RANGE[1]:
            np.minimum(np.maximum(counts, CONVERTER_RANGE[0], counts), CONVERTER_RANGE[1], counts)
        return counts * CONVERTER_STEP

    def _white(self) -> np.ndarray:
        """The noise of one sample, in steps of the converter: (1 + T,). Drawn for many samples at once, which is quicker."""
        if self._drawn == len(self._batch):
            self._drawn = 0
            np.multiply(self._noise, self._noise_rng.standard_normal(self._batch.shape), self._batch)
        self._drawn += 1
        return self._batch[self._drawn - 1]
