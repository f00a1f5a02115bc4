"""A taxel: Tekscan FlexiForce A201 (25 lbf) with the Phidgets 1120 adapter, read by the NI 9201.

    F_Taxel = V_Taxel Slope        (thesis eq 26; Table 3-1: 9.4 to 14.3 N/V, by unit and by day)

Order of the chain: bending of the calibration curve, hysteresis, drift of the gain per decade of time, what the slope has changed since
the calibration, noise, the adapter's 5 V, and the converter's 4.88 mV. The data sheet's response time of 5 µs is left out: no step of the
testbed sees it. Drift counts from the first sample, not from every loading.

The thesis puts the adapter's 5 V at 25 lbf, which would be 22.2 N/V and 0.11 N per step; its own Table 3-1 says 9.4 to 14.3 N/V, which
is 0.05 to 0.07 N per step and clips at 47 to 71 N. The table is measured, so it is followed.

Source: thesis 3.3.1 [43], [44]: linearity 3 %, repeatability 2.5 %, hysteresis 4.5 % of full scale, drift 5 % per decade, 40 % from part
to part.
"""

from dataclasses import dataclass

import numpy as np

from skin_models.effects.drift import LogGainDrift
from skin_models.effects.gain_error import GainError
from skin_models.effects.hysteresis import SensorHysteresis
from skin_models.effects.noise import Noise
from skin_models.effects.nonlinearity import Nonlinearity
from skin_models.effects.saturation import Saturation
from skin_models.parameter import check_parameters, quantity
from skin_models.sensors.adc import NI9201, Adc
from skin_models.sensors.sensor import POUND_FORCE, Sensor

CAPACITY = 25.0 * POUND_FORCE  # N
SUPPLY = 5.0  # V, where the adapter's output ends
MIDDLE_SLOPE = 11.75  # N/V, mean of the four taxels of Table 3-1
PART_TO_PART = 0.4  # greatest relative difference of a unit from the middle


@dataclass(frozen=True)
class FlexiForce:
    """One taxel. Relative sizes are shares of the capacity unless said otherwise."""

    slope: float = quantity("N/V", MIDDLE_SLOPE, lower=0.1, upper=1e3, doc="slope found by its calibration")
    change: float = quantity("1", 0.0, lower=-0.9, upper=9.0, doc="relative change of the reading since that calibration")
    nonlinearity: float = quantity("1", 0.0, lower=-0.1, upper=0.1, doc="deviation at half load")
    hysteresis: float = quantity("1", 0.02, lower=0.0, upper=0.2, doc="distance between loading and unloading")
    drift: float = quantity("1", 0.03, lower=-0.5, upper=0.5, doc="change of the gain per decade of time")
    noise: float = quantity("V", 0.0, lower=0.0, upper=1.0, doc="standard deviation of the adapter's noise")

    def __post_init__(self) -> None:
        check_parameters(self)

    @classmethod
    def drawn(cls, rng: np.random.Generator, noise: float = 0.0) -> "FlexiForce":
        """A taxel within its data sheet, calibrated: only its repeatability is left of the part-to-part error."""
        part, change, nonlinearity = rng.uniform(-1.0, 1.0, 3) * (PART_TO_PART, 0.025, 0.03)
        hysteresis, drift = rng.uniform(0.0, 1.0, 2) * (0.045, 0.05)
        slope = MIDDLE_SLOPE * (1.0 + part)
        return cls(slope=slope, change=change, nonlinearity=nonlinearity, hysteresis=hysteresis, drift=drift, noise=noise)

    def sensor(self, where: str = "taxel", adc: Adc = NI9201) -> Sensor:
        """The chain, with the slope of eq 26."""
        effects = (
            Nonlinearity(where=where, deviation=self.nonlinearity, capacity=CAPACITY),
            SensorHysteresis(where=where, relative=2.0 * self.hysteresis, threshold=CAPACITY / 4.0),
            LogGainDrift(where=where, per_decade=self.drift, tau=1.0),
            GainError(where=where, gain=self.change),
            Noise(where=where, white=self.noise * self.slope),
            Saturation(where=where, level=SUPPLY * self.slope),
            *adc.effects(where, self.slope),
        )
        return Sensor("FlexiForce A201 with Phidgets 1120", self.slope, effects)

    def uncalibrated(self, assumed: float = MIDDLE_SLOPE) -> "FlexiForce":
        """The same unit, read with a slope that is not its own: the part-to-part error in full."""
        change = (1.0 + self.change) * assumed / self.slope - 1.0
        return FlexiForce(**{**vars(self), "slope": assumed, "change": change})
