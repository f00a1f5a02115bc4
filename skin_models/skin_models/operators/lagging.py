"""The exact step of a first-order lag, for an input that is linear between samples."""

import math


def lag_factors(tau: float, dt: float) -> tuple[float, float]:
    """e and g of z[n] = e z[n-1] + (g - e) y[n-1] + (1 - g) y[n]: e = exp(-dt / tau), g = (1 - e) tau / dt; 0 and 0 where tau is 0."""
    if tau == 0.0:
        return 0.0, 0.0
    return math.exp(-dt / tau), -math.expm1(-dt / tau) * tau / dt
