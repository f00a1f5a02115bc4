"""Which other causes would leave nearly the same trace under the same protocol: where a critic must admit rivals."""

from functools import partial
from math import copysign

import numpy as np
from scipy.optimize import nnls

from .effect import Context, Skin
from .hidden import PLACES, Hide, build, forms
from .hidden_contact import Rate
from .hidden_skin import Shape
from .memory import Arms, Plays
from .rig import FORCE_STEP, OVER
from .sizing import find_amplitude, rms, visible

SMOOTH = (
    "nonlinear_stiffness", "stress_relaxation", "rate_dependence", "hysteresis", "cyclic_softening", "adhesion", "dead_zone",
    "friction", "position_offset", "mount_compliance", "backlash", "inertia", "gain_error", "force_offset", "drift", "saturation",
    "lag", "time_shift",
)  # fmt: skip
EITHER_SIGN = ("nonlinear_stiffness", "position_offset", "gain_error", "force_offset", "drift", "time_shift")
TELLABLE = 12.0  # twice the gain in log-likelihood from which two names can be told apart at best
NEARLY = 0.1  # part of its energy that a trace of another form than one's own may well leave


def energy(truth, session=0) -> float:
    """Sum of what is visible of everything hidden, squared over the noise: about twice the log-likelihood to be won in one session."""
    trace = _trace(truth.rig, [(h.effect, h.amplitude) for h in truth.hidden], session)
    return float(np.sum(trace**2))


def lookalikes(truth, nearly=NEARLY) -> list:
    """[(cause, where, energy left, must)] of other names that pass for the first hidden effect in session 0, best first.

    A rival passes when a sum of its elements explains the trace but for `TELLABLE` (`must` be admitted) or for `nearly` of it (may be).
    """
    hidden, rig = truth.hidden[0], truth.rig
    aim = _trace(rig, [(hidden.effect, hidden.amplitude)], 0)
    bound, found = max(TELLABLE, nearly * float(np.sum(aim**2))), []
    for cause in SMOOTH:
        for where in PLACES[cause]:
            if (cause, where) != (hidden.cause, hidden.where) and (left := _left_by(rig, cause, where, aim)) < bound:
                found.append((cause, where, round(left, 1), left < TELLABLE))
    return sorted(found, key=lambda row: row[2])


def _left_by(rig, cause, where, aim):
    """Energy of `aim` that no sum of the forms of a cause explains; the sum is positive where the cause has a sign."""
    columns = [_like(rig, effect, rms(aim)) for effect in _family(rig, cause, where)]
    columns = np.array([c for c in columns if np.any(c)]).T
    if not columns.size:
        return float(np.sum(aim**2))
    if cause in EITHER_SIGN:
        columns = np.column_stack([columns, -columns])
    return float(nnls(columns, aim)[1] ** 2)


def _family(rig, cause, where):
    """What a flexible critic would try for a cause: a dictionary of elements for a skin's memory and shape, else the forms."""
    k, d, load = rig.skin.stiffness, rig.skin.depth_max, 0.5 * rig.skin.stiffness * rig.skin.depth_max
    if cause == "stress_relaxation":
        return [Skin(partial(Arms, [0.1 * k], [tau])) for tau in np.geomspace(0.03, 40, 11)]
    if cause == "hysteresis" and where == "skin":
        return [Skin(partial(Plays, [0.1 * load / r], [r])) for r in d * np.geomspace(0.01, 0.9, 11)]
    if cause == "nonlinear_stiffness":
        powers = (1.2, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0)
        return [Skin(partial(Shape, lambda u, p=p: 0.1 * load * (u / d) ** p, d)) for p in powers]
    if cause == "rate_dependence":
        speeds, depths = (0.2, 0.5, 1.0, 1.6, 2.4), (0.0, 1.0, 2.0)
        return [Rate(partial(_power, 0.1 * load, 2 * d, d, n, m)) for n in speeds for m in depths if (n, m) != (1.0, 0.0)]
    contexts = [Context(rig.stream(8, i), rig.skin, where, FORCE_STEP, rig.taxel_steps, rig.rate) for i in range(len(forms(cause, where)))]
    return [build(Hide(cause, where, name), c) for name, c in zip(forms(cause, where), contexts, strict=True)]


def _power(f, w0, d, n, m, u, w):
    return copysign(f * (abs(w) / w0) ** n, w) * (u / d) ** m if u > 0 else 0.0


def _like(rig, effect, size):
    """The trace of an effect whose RMS is about `size`."""
    a = find_amplitude(lambda a: rms(_trace(rig, [(effect, a)], 0)), size, tries=3, tolerance=0.4, limit=effect.limit)
    return _trace(rig, [(effect, a)], 0)


def _trace(rig, effects, number):
    """Visible signals of all channels in one row, over the noise, whitened if that is an AR(1)."""
    coarse = rig.coarse([e for e, _ in effects])
    clean, said = rig.clean(number, effects, coarse)
    force, taxels = visible(rig.finish(clean, number, effects), rig.base(number, coarse, said), OVER // coarse)
    floor = rig.noise_rms()
    rows = np.column_stack([force / floor["force"], taxels / np.array(floor["taxels"])])
    rho = rig.noise.rho if rig.noise.kind.startswith("ar") else 0.0
    before = np.vstack([rows[:1] * rho, rows[:-1]])
    return ((rows - rho * before) / np.sqrt(1 - rho**2)).T.ravel()
