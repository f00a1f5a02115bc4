"""The analog input of the testbed: it clips at its range and rounds to its code width.

    code width = 2 range / 2^bits        NI 9201: 20 V / 4096 = 4.88 mV

Source: thesis 3.1 [39] and NI 9201 data sheet.
"""

from dataclasses import dataclass

from skin_models.effect import Effect
from skin_models.effects.quantization import SensorQuantization
from skin_models.effects.saturation import Saturation
from skin_models.errors import ModelError


@dataclass(frozen=True)
class Adc:
    """A converter over ±`volts`. Raises `ModelError` unless bits and range are positive."""

    bits: int
    volts: float

    def __post_init__(self) -> None:
        if not (self.bits >= 1 and self.volts > 0.0):
            raise ModelError(f"an ADC needs at least one bit and a positive range, not {self.bits} bits over ±{self.volts} V")

    @property
    def code_width(self) -> float:
        """Volts per step."""
        return 2.0 * self.volts / 2**self.bits

    def effects(self, where: str, slope: float) -> tuple[Effect, ...]:
        """Clipping and rounding, as effects on a force that makes 1 / `slope` volts per newton."""
        return (
            Saturation(where=where, level=self.volts * slope),
            SensorQuantization(where=where, step_force=self.code_width * slope),
        )


NI9201 = Adc(bits=12, volts=10.0)
