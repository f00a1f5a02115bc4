"""The sensors of the thesis's testbed (chapter 3) as chains of effects, with the truth beside what they measure."""

from skin_models.sensors.adc import NI9201, Adc
from skin_models.sensors.bank import TaxelBank
from skin_models.sensors.flexiforce import FlexiForce
from skin_models.sensors.load_cell import LoadCell
from skin_models.sensors.sensor import Reading, Sensor

__all__ = ["NI9201", "Adc", "FlexiForce", "LoadCell", "Reading", "Sensor", "TaxelBank"]
