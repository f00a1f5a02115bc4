"""Whether the zeros of depth and forces matter. A depth whose zero is two micrometres off the surface changes a stiffness by more than its
standard error, which only accounts for noise.
"""

from collections.abc import Sequence
from contextlib import suppress

from skin_ident.estimators.dispersion import fit_dispersion
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import HALF_95, Estimate
from skin_ident.estimators.figures import plus_minus
from skin_ident.recordings.recording import Recording
from skin_models.signals import Motion

FAR = 2.0  # half widths of the 95 % interval by which a parameter must change for a warning


def zero_warnings(
    estimate: Estimate, recordings: Sequence[Recording], mass: float | str = 0.0, motions: Sequence[Motion] | None = None
) -> list[str]:
    """A sentence about the parameter of `estimate` (SI) that changes most when every channel gets a zero offset, where it changes by more
    than FAR."""
    with suppress(FitError):  # where the motion does not identify the zeros there is no such fit
        free = fit_dispersion(recordings, mass, motions, offsets=True)
        far = {n: _half_widths(estimate, free, n) for n, s in estimate.std.items() if s > 0.0 and free.std.get(n, 0.0) > 0.0}
        name = max(far, key=far.get, default="")
        if name and far[name] > FAR:
            found = f"{name} comes out at {plus_minus(free.values[name], HALF_95 * free.std[name])}"
            return [f"with a zero of its own for every channel (--offsets) {found}, outside of its interval: "
                    "the zero of the depth, or of a channel, seems a little off"]  # fmt: skip
    return []


def _half_widths(one: Estimate, other: Estimate, name: str) -> float:
    """The difference of two estimates of a parameter over the combined half width of their 95 % intervals."""
    halves = [(high - low) / 2 for low, high in (one.interval(name), other.interval(name))]
    return abs(one.values[name] - other.values[name]) / (halves[0] ** 2 + halves[1] ** 2) ** 0.5
