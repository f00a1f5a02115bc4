"""The dispersion model by linear least squares (thesis eqs 9 to 24 and 27 to 31).

    taxel i   F_i  = s_i (b1 v + k1 x)
    force     F_LC = m (a - g) + (b1 + b2) v + (k1 + k2) x

with depth x, speed v and acceleration a. The terms are zero in the air, and where the skin would pull. Skin that the plunger has left
behind recovers by itself. If the taxels are seen to feel that, x and v are then those of the skin's surface; otherwise the terms are zero.
The mass is estimated (Table 4-4), or held at a known value (Table 4-5). Taxels beside the plunger have the b1 and k1 of the strongest taxel
times a share (a fit of rank one, weighted by their noise).
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from skin_ident.estimators.converter import with_steps
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import Estimate, Residual, complaints
from skin_ident.estimators.left_over import left_over
from skin_ident.estimators.regression import Block, Regression, regress
from skin_ident.estimators.robust import CLOSE, LINEAR, Tamed, noted, tamed
from skin_ident.estimators.sessions import Session, prepare
from skin_ident.estimators.split import jacobian, metric_of, split, weights_of
from skin_ident.estimators.verdicts import judge, mass_at_bound, negative, where_explained
from skin_ident.recordings.recording import Recording
from skin_models.dispersion import Dispersion
from skin_models.model import Model
from skin_models.parameter import Parameter, parameters_of
from skin_models.signals import Motion

FREE = "free"
FAINT = 0.02  # share that the noise of a taxel far from the plunger may produce, with either sign
LACKING = "the plain model lacks something (or the depth is noisy), so that values and intervals do not hold; run diagnose to see what"
ROBUST_ROUNDS = 20  # of a robust loss, at most
ROUNDS = 10  # at most, until the contact samples no longer change


@dataclass(frozen=True)
class Shape:
    """The structure of the fit: whether there is a load cell (`force`), whether the mass is `free` or held at `mass` (kg), whether each
    session has `offsets`, which taxels (`live`) of all `total` take part, and whether taxels feel skin that recovers by itself
    (`recovers`)."""

    force: bool
    free: bool
    mass: float
    offsets: bool
    live: tuple[int, ...]
    total: int
    recovers: bool = False

    @property
    def taxels(self) -> int:
        """Number of taxels that take part."""
        return len(self.live)


def fit_dispersion(
    recordings: Sequence[Recording],
    mass: float | str = 0.0,
    motions: Sequence[Motion] | None = None,
    *,
    offsets: bool = False,
    method: str = "linear least squares",
    loss: str = LINEAR,
) -> Estimate:
    """Fit one dispersion model to all sessions. `mass` is FREE or a value in kg; `motions` replaces the measured motion.

    All sessions share the skin's parameters. `offsets` fits a zero offset per channel and session, which is reported in the notes; `loss`
    is one of `robust.LOSSES`. Raises `FitError` where the recordings lack what the fit needs.
    """
    sessions, warnings = prepare(recordings, motions)
    asked = shape_of(sessions, mass, offsets)
    shape, sessions, (regression, blocks), held = within_bounds(sessions, asked, loss)
    beta, to = np.concatenate(regression.coefficients), theta_of(regression, shape)
    theta, to_theta = to(beta), jacobian(to, beta)
    known = with_steps(sessions, regression, blocks, said(sessions, shape, regression), [t.rows for t in held] or None)
    if held:
        to_theta = to_theta / np.concatenate([np.full(c.size, t.slope) for c, t in zip(regression.coefficients, held, strict=True)])
    left = left_over(channel_names(shape), regression, blocks, list(zip(*(s.raw for s in sessions), strict=True)), -1)
    if left and left.lacking:
        warnings = (*warnings, f"{left.words}: {LACKING}")
    more = noted(loss, dict(zip(channel_names(shape), held, strict=False)))
    method += "" if loss == LINEAR else f", {loss} loss"
    estimate = _estimate(method, sessions, shape, regression, theta, to_theta @ known @ to_theta.T, warnings, more)
    return estimate if shape == asked else replace(estimate, verdicts={**estimate.verdicts, "m": mass_at_bound()})


def shape_of(sessions: list[Session], mass: float | str, offsets: bool) -> Shape:
    """The structure of the fit for these sessions. Raises `FitError` where the mass, or anything at all, cannot be fitted."""
    force, taxels = sessions[0].force is not None, len(sessions[0].taxels)
    if not force and not taxels:
        raise FitError(f"{sessions[0].name} holds no force in newtons: neither a load cell nor a calibrated taxel")
    if isinstance(mass, str) and mass != FREE:
        raise FitError(f"mass is {mass!r}; it must be a number in kg, or {FREE}")
    free = mass == FREE
    if free and not force:
        raise FitError("the mass acts on the load cell alone (eq 27), and there is no load cell in these recordings")
    told = (sessions[0].live, sessions[0].total, force and taxels > 0 and recovery_is_felt(sessions))
    return Shape(force, free, 0.0 if free else float(mass), offsets, *told)


def recovery_is_felt(sessions: list[Session]) -> bool:
    """Whether the taxels' readings after the plunger has left the skin are nearer to the force of recovering skin than to zero."""
    touched = np.concatenate([s.terms()[:2] for s in sessions], axis=1)
    read = np.concatenate([np.array(s.raw) for s in sessions], axis=1)
    b, k = np.linalg.lstsq(touched.T, read.T, rcond=None)[0]
    if b[0] <= 0.0 or k[0] <= 0.0:
        return False
    alone = np.concatenate([s.left_alone(b[0] / k[0]) for s in sessions], axis=1)
    pressed = np.column_stack([b, k])[1:] @ alone
    return bool(np.sum(pressed * read[1:]) > 0.5 * np.sum(pressed**2))


def settled(sessions: list[Session], shape: Shape) -> tuple[Regression, list[list[Block]]]:
    """The regression and its blocks, repeated until the samples at which the skin parts from the plunger no longer change."""
    recovery = None
    for _ in range(ROUNDS):
        blocks = _blocks(sessions, shape, recovery)
        regression = regress(blocks)
        new = recovery_of(regression)
        if recovery is not None and abs(new - recovery) <= 1e-6 * abs(new):
            break
        recovery = new
    return regression, blocks


def within_bounds(
    sessions: list[Session], shape: Shape, loss: str = LINEAR
) -> tuple[Shape, list[Session], tuple[Regression, list[list[Block]]], list[Tamed]]:
    """The shape that was fitted, and `robustly` for it: a free mass that comes out negative is held at zero, the best that physics allows.
    Raises `FitError`."""
    fitted = robustly(sessions, shape, loss)
    regression, _ = fitted[1]
    if shape.free and regression.coefficients[0][-3] < 0.0:
        return within_bounds(sessions, replace(shape, free=False), loss)
    return shape, *fitted


def robustly(
    sessions: list[Session], shape: Shape, loss: str = LINEAR
) -> tuple[list[Session], tuple[Regression, list[list[Block]]], list[Tamed]]:
    """`settled` under a loss: the sessions as they were fitted, the regression with its blocks, and the `Tamed` samples of every channel
    (empty for least squares). Raises `FitError`.
    """
    found, held = settled(sessions, shape), []
    believed = [s.believed for s in sessions]
    for _ in range(ROBUST_ROUNDS if loss != LINEAR else 0):
        values = said(sessions, shape, found[0])
        held = [tamed([s.raw[c] for s in sessions], value, believed, loss) for c, value in enumerate(values)]
        before = np.concatenate(found[0].coefficients)
        sessions = [s.with_rows([t.rows[i] for t in held]) for i, s in enumerate(sessions)]
        found = settled(sessions, shape)
        if np.all(np.abs(np.concatenate(found[0].coefficients) - before) <= CLOSE * np.sqrt(np.diag(found[0].covariance))):
            break
    return sessions, found, held


def recovery_of(regression: Regression) -> float:
    """The skin's time constant of recovery b / k (s), from the load cell or, without one, the first taxel."""
    b, k = regression.coefficients[0][-2:]
    return float(b / k) if k > 0.0 else 0.0


def said(sessions: list[Session], shape: Shape, regression: Regression) -> list[list[np.ndarray]]:
    """The prediction of the fit, N, as [channel][session] arrays (N,) at full rate."""
    out: list[list[np.ndarray]] = [[] for _ in regression.coefficients]
    for i, s in enumerate(sessions):
        recovery = recovery_of(regression)
        v, x, a, g = s.terms(recovery)
        alone = s.left_alone(recovery) * shape.recovers
        for c, coefficients in enumerate(regression.coefficients):
            b, k = coefficients[-2:]
            if c == shape.force:  # the load cell comes first, and does not feel skin that recovers
                v, x = v + alone[0], x + alone[1]
            mass = 0.0 if c or not shape.force else coefficients[-3] if shape.free else shape.mass
            out[c].append(b * v + k * x + mass * (a + g) + (coefficients[i] if shape.offsets else 0.0))
    return out


def _blocks(sessions: list[Session], shape: Shape, recovery: float | None) -> list[list[Block]]:
    """Blocks of the regression by channel, the force first, then the taxels. Columns: (offsets, one per session,) (a - g,) v, x for the
    force; (offsets,) v, x for a taxel."""
    channels: list[list[Block]] = [[] for _ in range(shape.force + shape.taxels)]
    for i, s in enumerate(sessions):
        v, x, a, g = s.columns(recovery).T
        zeros = np.tile(np.arange(len(sessions)) == i, (v.size, 1)).astype(float) if shape.offsets else np.empty((v.size, 0))
        columns = np.column_stack([zeros, v, x])
        beside = np.column_stack([zeros, np.column_stack([v, x]) + s.columns_left_alone(recovery)]) if shape.recovers else columns
        rows = [(y, beside) for y in s.taxels]
        if shape.force:
            inertial = a + g
            with_mass = np.column_stack([zeros, inertial, v, x])
            rows.insert(0, (s.force, with_mass) if shape.free else (s.force - shape.mass * inertial, columns))
        for part in s.parts:
            for blocks, (y, h) in zip(channels, rows, strict=True):
                blocks.append(Block(y[part], h[part], s.prefilter.kernel))
    return channels


def theta_of(regression: Regression, shape: Shape) -> Callable[[np.ndarray], np.ndarray]:
    """A function from all coefficients, channel by channel, to (m, b1, k1, b2, k2, shares)."""
    ends = np.cumsum([c.size for c in regression.coefficients])
    weights = weights_of(np.array(regression.noise[len(regression.noise) - shape.taxels :]))
    metric = metric_of(regression.inverses[-1][-2:, -2:])

    def theta(beta: np.ndarray) -> np.ndarray:
        pairs = np.array([beta[end - 2 : end] for end in ends])
        m = beta[ends[0] - 3] if shape.free else shape.mass
        return np.concatenate([[m], split(pairs[0] if shape.force else None, pairs[int(shape.force) :], weights, metric)])

    return theta


def _zeros(sessions: list[Session], shape: Shape, regression: Regression) -> dict[str, dict[str, float]]:
    """The offset of every channel in every session, N."""
    if not shape.offsets:
        return {}
    pairs = zip(channel_names(shape), regression.coefficients, strict=True)
    return {"offsets_n": {name: {s.name: float(z) for s, z in zip(sessions, c, strict=False)} for name, c in pairs}}


def _estimate(
    method, sessions, shape: Shape, regression: Regression, theta: np.ndarray, covariance: np.ndarray, warnings, more
) -> Estimate:
    m, b1, k1, b2, k2, *shares = (float(value) for value in theta)
    if k1 < 0.0:
        falling = [name for name, c in zip(channel_names(shape), regression.coefficients, strict=True) if c[-1] < 0.0]
        falls = f"{' and '.join(falling) or 'what was measured'} fall{'' if len(falling) > 1 else 's'} while the skin is pressed"
        mend = "turn the sign round there, or leave out what does not belong to this depth"
        raise FitError(f"the stiffness comes out negative ({k1:.4g} N/m), for {falls}: {mend}")
    notes = [_of_negative(i, s) for i, s in zip(shape.live, shares, strict=True) if s < 0.0]
    source = ", ".join(s.name for s in sessions)
    model = Model(Dispersion(m=m, b1=b1, k1=k1, b2=b2, k2=k2), _placed(shares, shape), source=source)
    covariance = _with_silent(covariance, shape)
    named = (*parameters_of(model.dispersion), *(Parameter(f"share_{i}", "1", s) for i, s in enumerate(model.shares)))
    residuals = _residuals(shape, regression)
    notes += complaints(residuals)
    verdicts, contributions = judge(sessions, shape, named, covariance)
    verdicts = where_explained(verdicts, contributions, residuals)
    notes += negative({name: v.word for name, v in verdicts.items()})
    return Estimate(
        method=method,
        model=model,
        parameters=named,
        covariance=covariance,
        verdicts=verdicts,
        residuals=residuals,
        contributions=contributions,
        condition=regression.condition,
        dof=regression.dof,
        sessions=tuple(s.name for s in sessions),
        warnings=(*warnings, *notes),
        notes={"telemetry": {s.name: s.quality.as_dict() for s in sessions}, **_zeros(sessions, shape, regression), **more},
    )


def _of_negative(taxel: int, share: float) -> str:
    falls = ": it falls while the skin is pressed, so its sign is wrong" if share < -FAINT else ""
    return f"taxel_{taxel}: its share came out at {share:.3g} and was set to 0{falls}"


def _placed(shares: list[float], shape: Shape) -> tuple[float, ...]:
    """The shares of all taxels, 0 for those that take no part; empty where no taxel is fitted."""
    known = dict(zip(shape.live, shares, strict=True))
    return tuple(max(0.0, known.get(i, 0.0)) for i in range(shape.total)) if shape.live else ()


def _with_silent(covariance: np.ndarray, shape: Shape) -> np.ndarray:
    """The covariance (P, P) with rows and columns of zeros inserted for taxels that take no part."""
    before = len(covariance) - shape.taxels
    count = before + (shape.total if shape.live else 0)
    out = np.zeros((count, count))
    places = [*range(before), *(before + i for i in shape.live)]
    out[np.ix_(places, places)] = covariance
    return out


def channel_names(shape: Shape) -> list[str]:
    """Names of the channels in the order of the regression."""
    return ["force"] * shape.force + [f"taxel_{i}" for i in shape.live]


def _residuals(shape: Shape, regression: Regression) -> dict[str, Residual]:
    rows = zip(channel_names(shape), regression.measured, regression.residuals, regression.ar, regression.noise, strict=True)
    return {name: _residual(np.concatenate(y), np.concatenate(e), ar, noise) for name, y, e, ar, noise in rows}


def _residual(y: np.ndarray, e: np.ndarray, ar: np.ndarray, noise: float) -> Residual:
    mse, spread, power = float(np.mean(e**2)), float(np.var(y)), float(np.mean(y**2))
    return Residual(
        rmse=mse**0.5,
        r2=1.0 - mse / spread if spread > 0 else 0.0,
        relative_mse=mse / power if power > 0 else float("nan"),
        ar=tuple(float(a) for a in ar),
        noise=noise,
    )
