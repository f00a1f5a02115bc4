"""Linear viscoelastic elements (thesis 2.3.1, figure 2-3): closed forms, and exact steps that agree with them to rounding.

    Spring(k=…)                   f = k x                                      eq 1
    Dashpot(b=…)                  f = b x'                                     eq 2
    KelvinVoigt(k=…, b=…)         both in parallel                             eqs 3 to 5
    Maxwell(k=…, b=…)             both in series                               eqs 6 to 8
    StandardSolid(k=…, k1=…, b1=…)  a spring beside a Maxwell arm              figure 2-3 (c)
    Prony(k=…, b=…, arms=…)       a spring, a dashpot and any number of arms   generalised Maxwell
    Springpot(c=…, alpha=…, …)    f = c d^alpha x / dt^alpha                   fractional, as a Prony series of stated error

The thesis writes stress and strain; here force (N) and depth (m), so that k is a stiffness and b a damping of a whole specimen.
"""

from skin_models.elements.basic import Dashpot, KelvinVoigt, Maxwell, Spring, StandardSolid
from skin_models.elements.element import Element
from skin_models.elements.prony import Prony
from skin_models.elements.springpot import Springpot

__all__ = ["Dashpot", "Element", "KelvinVoigt", "Maxwell", "Prony", "Spring", "Springpot", "StandardSolid"]
