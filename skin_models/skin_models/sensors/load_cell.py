"""The load cell: Transducer Techniques MLP-25 with the TMO-1 conditioner, read by the NI 9201.

    F_LC = V_LC 25 lbf / 8 V 4.44822 N / lbf        (thesis eq 25)

Order of the chain: bending of the calibration curve, hysteresis, gain of the run, zero balance, the conditioner's 2200 Hz filter (first
order), its noise, its 0 … 8 V output, and the converter's 4.88 mV, which are 0.068 N.

Source: thesis 3.3.3 [46]: nonlinearity and hysteresis 0.1 %, nonrepeatability 0.05 %, zero balance 1 % of the rated output.
"""

from dataclasses import dataclass

import numpy as np

from skin_models.effects.force_offset import ForceOffset
from skin_models.effects.gain_error import GainError
from skin_models.effects.hysteresis import SensorHysteresis
from skin_models.effects.lag import Lag
from skin_models.effects.noise import Noise
from skin_models.effects.nonlinearity import Nonlinearity
from skin_models.effects.saturation import Saturation
from skin_models.parameter import check_parameters, quantity
from skin_models.sensors.adc import NI9201, Adc
from skin_models.sensors.sensor import POUND_FORCE, Sensor

CAPACITY = 25.0 * POUND_FORCE  # N
OUTPUT = 8.0  # V at capacity
OVERLOAD = 1.25  # of the output where the conditioner clips: its supply is 12 V, and the converter ends at 10 V


@dataclass(frozen=True)
class LoadCell:
    """One unit. Relative sizes are shares of the rated output; the bounds are wider than the data sheet so that a faulty one can be had."""

    zero: float = quantity("1", 0.0, lower=-0.1, upper=0.1, doc="zero balance that is left after zeroing the conditioner")
    nonlinearity: float = quantity("1", 0.001, lower=-0.05, upper=0.05, doc="deviation at half load")
    hysteresis: float = quantity("1", 0.001, lower=0.0, upper=0.05, doc="distance between loading and unloading")
    gain: float = quantity("1", 0.0, lower=-0.1, upper=0.1, doc="error of the slope in this run")
    noise: float = quantity("V", 0.0, lower=0.0, upper=1.0, doc="standard deviation of the conditioner's noise")
    bandwidth: float = quantity("Hz", 2200.0, lower=1.0, upper=1e6, doc="-3 dB point of the conditioner's filter")

    def __post_init__(self) -> None:
        check_parameters(self)

    @classmethod
    def drawn(cls, rng: np.random.Generator, noise: float = 0.0) -> "LoadCell":
        """A unit within its data sheet, not zeroed: every error evenly within its limits."""
        zero, nonlinearity, gain = rng.uniform(-1.0, 1.0, 3) * (0.01, 0.001, 0.0005)
        return cls(zero=zero, nonlinearity=nonlinearity, hysteresis=rng.uniform(0.0, 0.001), gain=gain, noise=noise)

    def sensor(self, where: str = "load_cell", adc: Adc = NI9201) -> Sensor:
        """The chain, with the slope of eq 25."""
        slope = CAPACITY / OUTPUT
        effects = (
            Nonlinearity(where=where, deviation=self.nonlinearity, capacity=CAPACITY),
            SensorHysteresis(where=where, relative=2.0 * self.hysteresis, threshold=CAPACITY / 4.0),
            GainError(where=where, gain=self.gain),
            ForceOffset(where=where, offset=self.zero * CAPACITY),
            Lag(where=where, tau=1.0 / (2.0 * np.pi * self.bandwidth)),
            Noise(where=where, white=self.noise * slope),
            Saturation(where=where, level=OVERLOAD * CAPACITY),
            *adc.effects(where, slope),
        )
        return Sensor("MLP-25 with TMO-1", slope, effects)
