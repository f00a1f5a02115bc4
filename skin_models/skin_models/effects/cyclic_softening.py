"""Cyclic softening (Mullins effect): below the greatest depth so far the skin is softer than it was the first time.

                y' = y (1 - s erf((X^2 - x^2) / l^2)),    X = greatest depth so far
    springs     y' = y - k x erf((X^2 - x^2) / l^2)

Both branches lose the share s, or their springs alone the stiffness k, where they are reloaded well below X, and nothing on the virgin
curve (x = X). With the stored energy W ~ x^2 this is Ogden and Roxburgh's pseudo-elasticity: s = 1 / r and l^2 stands for their m. The skin
does not heal.

Source: R. W. Ogden and D. G. Roxburgh, A pseudo-elastic model for the Mullins effect in filled rubber, Proc. R. Soc. A 455 (1999)
2861-2877.
"""

from dataclasses import dataclass
from typing import ClassVar

from scipy.special import erf

from skin_models.effect import Place
from skin_models.operators.greatest_depth import OfTheForce, OfTheSprings
from skin_models.parameter import SHAPE, quantity


@dataclass(frozen=True)
class CyclicSoftening(OfTheForce):
    """Softening below the greatest depth so far."""

    cause: ClassVar[str] = "cyclic_softening"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Ogden and Roxburgh 1999"
    linear: ClassVar[bool] = True

    softening: float = quantity("1", 0.0, lower=0.0, upper=0.95, typical=0.2, doc="greatest share s of the force that is lost")
    length: float = quantity(
        "m", 0.5e-3, lower=1e-5, upper=0.05, role=SHAPE, typical=0.5e-3, scan=(0.1e-3, 0.25e-3, 0.5e-3, 1e-3, 2e-3), doc="depth scale l"
    )

    def factor(self, x, greatest):
        """1 - s erf((X^2 - x^2) / l^2)."""
        return 1.0 - self.softening * erf((greatest - x) * (greatest + x) / self.length**2)


@dataclass(frozen=True)
class SofterSprings(OfTheSprings):
    """The same softening for the springs alone."""

    cause: ClassVar[str] = "cyclic_softening"
    form: ClassVar[str] = "springs"
    places: ClassVar = {"skin": Place.SKIN}
    source: ClassVar[str] = "Ogden and Roxburgh 1999, beside linear damping"

    length: float = quantity(
        "m", 0.5e-3, lower=1e-5, upper=0.05, role=SHAPE, typical=0.5e-3, scan=(0.2e-3, 0.5e-3, 1e-3), doc="depth scale l"
    )

    def share(self, x, greatest):
        """erf((X^2 - x^2) / l^2)."""
        return erf((greatest - x) * (greatest + x) / self.length**2)
