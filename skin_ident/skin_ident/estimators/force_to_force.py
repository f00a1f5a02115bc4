"""The dispersion model from force to force, without a depth (thesis eq 32 and Table 4-7).

    taxel(s) / force(s) = (b1 s + k1) / (m s^2 + (b1 + b2) s + (k1 + k2))

Only ratios of the parameters can be identified. Order 2 gives those of the thesis, each parameter over m. Order 1 leaves out the mass, and
for a gram of skin that is all that the data support: the static share k1 / (k1 + k2), and the times b1 / k1 (lead) and
(b1 + b2) / (k1 + k2) (lag).
"""

from collections.abc import Callable, Sequence

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import IDENTIFIABLE, NEGATIVE, NOT_IDENTIFIABLE, WEAK, Estimate, Residual, Verdict
from skin_ident.estimators.force_band import fit_in_band
from skin_ident.estimators.prefilter import prefilters_for
from skin_ident.estimators.robust import LINEAR, noted
from skin_ident.estimators.sessions import NO_STRETCH, because, stretches
from skin_ident.estimators.split import jacobian
from skin_ident.estimators.transfer_data import Pair
from skin_ident.estimators.transfer_fit import TransferFit
from skin_ident.estimators.verdicts import word_of
from skin_ident.quality import FAR_TOO_LITTLE, MOST_FELT, inspected
from skin_ident.recordings.carried import said_of
from skin_ident.recordings.recording import Recording
from skin_models.parameter import Parameter

FIRST = (
    ("share", "1", "static share of the force that the taxel feels, k1 / (k1 + k2)"),
    ("lead", "s", "b1 / k1"),
    ("lag", "s", "(b1 + b2) / (k1 + k2)"),
)
CHANCE = 6.63  # 99th percentile of chi-square with one degree of freedom
OVERDONE = "a function of order 1 explains these data as well, so they do not tell what the mass does: take order 1"
SHORTEST = 40  # samples of the shortest stretch that is fitted
RELATED = 0.7  # least correlation of two channels for a meaningful slope
SECOND = (("b1_over_m", "1/s", ""), ("k1_over_m", "1/s^2", ""), ("b2_over_m", "1/s", ""), ("k2_over_m", "1/s^2", ""))


def fit_force_to_force(
    recordings: Sequence[Recording], order: int = 1, taxel: int | None = None, offset: bool | None = None, loss: str = LINEAR
) -> Estimate:
    """One transfer function from the load cell to a taxel (the strongest, if none is named), over all sessions. Raises `FitError`.

    `offset` fits a constant per session; None does so for a taxel in volts, whose zero is unknown. `loss`, one of `robust.LOSSES`, applies
    to the taxel's residual. It does not help against spikes of the load cell, which pass through the model: only telemetry finds those.
    """
    if order not in (1, 2):
        raise FitError(f"the order is 1 (without mass) or 2 (thesis eq 32), not {order}")
    if any(r.uneven for r in recordings):
        raise FitError("from force to force, samples must be evenly spaced: leave --keep-stamps out")
    lacking = [r.name for r in recordings if r.force is None or not len(r.taxels)]
    if lacking:
        raise FitError(f"{', '.join(lacking)}: a fit from force to force needs a load cell and a taxel")
    looked = [inspected(r) for r in recordings]
    recordings = [r.warned(*q.warnings) for r, _, q in looked]
    index = _strongest(recordings[0], looked[0][1]) if taxel is None else taxel
    if not all(0 <= index < len(r.taxels) for r in recordings):
        raise FitError(f"there is no taxel {index} in every recording")
    pairs = [p for r, (_, good, _) in zip(recordings, looked, strict=True) for p in _pairs(r, index, good)]
    unit = recordings[0].taxel_units[index]
    _plausible(pairs, unit)
    how = (unit == "V" if offset is None else offset, loss)
    fit, held = fit_in_band(pairs, order, *how)
    more = noted(loss, {f"taxel_{index}": held} if held else {})
    doubt = OVERDONE if order == 2 and not _better(fit, pairs, how) else ""
    return _estimate(fit, pairs, order, index, unit, more, tuple(said_of(r.name, w) for r in recordings for w in r.warnings), doubt)


def _better(fit: TransferFit, pairs: Sequence[Pair], how: tuple[bool, str]) -> bool:
    """Whether a second pole lowers the residual significantly. If it does not, its place is arbitrary, and so are the other
    coefficients."""
    try:
        simple, _ = fit_in_band(pairs, 1, *how)
    except FitError:
        return True
    filters = prefilters_for([(p.u, p.dt) for p in pairs])
    rows = sum(e.size * min(1.0, 2.0 * q.edge * q.dt * q.every) for e, q in zip(fit.residuals, filters, strict=True))
    rows = max(2.0, min(rows, fit.dof))  # number of independent rows
    left = [max(sum(float(e @ e) for e in f.residuals), 1e-300) for f in (simple, fit)]
    return rows * float(np.log(left[0] / left[1])) > max(CHANCE, np.log(rows))


def _pairs(r: Recording, index: int, good: np.ndarray) -> list[Pair]:
    """The stretches of a recording in which all samples are trusted. Raises `FitError` where there is none."""
    parts = stretches(good, SHORTEST)
    if not parts:
        raise FitError(f"{r.name}: {NO_STRETCH}{because(r)}")
    taxel = r.taxels[index]
    return [Pair(r.name, np.ascontiguousarray(r.force[p]), np.ascontiguousarray(taxel[p]), r.dt) for p in parts]


def _plausible(pairs: Sequence[Pair], unit: str) -> None:
    """Raises `FitError` for a taxel that never changes, falls under load, or feels an implausible share of the force."""
    u, y = (np.concatenate([getattr(p, name) - getattr(p, name).mean() for p in pairs]) for name in "uy")
    if not y.any():
        raise FitError(f"{pairs[0].name}: no taxel ever changes: they are dead")
    norm = float(np.sqrt((u @ u) * (y @ y)))
    slope = float(u @ y / (u @ u)) if norm > 0.0 and abs(u @ y) > RELATED * norm else None
    if slope is None or unit != "N":
        return
    if slope < 0.0:
        raise FitError(f"{pairs[0].name}: the taxel falls when the force rises: check their signs (compression is positive)")
    if not FAR_TOO_LITTLE < slope < MOST_FELT:
        raise FitError(f"{pairs[0].name}: the taxel feels {slope:.3g} times the force: check units and calibrations")


def _strongest(r: Recording, good: np.ndarray) -> int:
    """The taxel with the largest covariance with the force, over trusted samples. (Its range would depend on spikes and clipping.)"""
    u = (r.force - r.force[good].mean()) * good if good.any() else r.force
    return int(np.argmax(np.abs(r.taxels @ u)))


def _first(theta: np.ndarray) -> np.ndarray:
    b1, b0, a0 = theta
    return np.array([b0 / a0, b1 / b0, 1.0 / a0])


def _second(theta: np.ndarray) -> np.ndarray:
    b1, b0, a1, a0 = theta
    return np.array([b1, b0, a1 - b1, a0 - b0])


def _estimate(
    fit: TransferFit, pairs: Sequence[Pair], order: int, index: int, unit: str, more, warnings: tuple[str, ...], doubt: str
) -> Estimate:
    to: Callable[[np.ndarray], np.ndarray] = _first if order == 1 else _second
    theta = fit.function.theta
    values, j = to(theta), jacobian(to, theta)
    covariance = j @ fit.covariance @ j.T
    named = tuple(Parameter(n, u, float(v), doc=doc) for (n, u, doc), v in zip(FIRST if order == 1 else SECOND, values, strict=True))
    channel, scale = f"taxel_{index}", np.sqrt(np.diag(fit.covariance))
    scaled = fit.covariance / np.outer(scale, scale) if np.all(scale > 0) else np.eye(scale.size)
    residual = _residual(fit, unit)
    left = doubt or ("" if fit.converged else "the search did not settle: these numbers are not a minimum")
    return Estimate(
        method=f"transfer function of order {order}, output error" + (f", {more['loss']['name']} loss" if more else ""),
        model=None,
        parameters=named,
        covariance=covariance,
        verdicts=_judged(named, np.sqrt(np.diag(covariance)), left or " ".join(residual.complaint(channel))),
        residuals={channel: residual},
        contributions={p.name: {} for p in named},
        condition=float(np.linalg.cond(scaled)),
        dof=fit.dof,
        sessions=tuple(dict.fromkeys(p.name for p in pairs)),
        warnings=(*warnings, *([left] if left else []), *residual.complaint(channel)),
        notes={"numerator": fit.function.numerator, "denominator": fit.function.denominator, "input": "force", "output": channel, **more},
    )


def _residual(fit: TransferFit, unit: str) -> Residual:
    y, e = np.concatenate(fit.measured), np.concatenate(fit.residuals)
    mse, power = float(np.mean(e**2)), float(np.mean(y**2))
    r2 = 1.0 - mse / max(float(np.var(y)), 1e-300)
    return Residual(mse**0.5, r2, mse / max(power, 1e-300), tuple(map(float, fit.ar)), fit.noise, unit)


def _judged(parameters: Sequence[Parameter], std: np.ndarray, reason: str) -> dict[str, Verdict]:
    """Verdicts by parameter; all are not identifiable where a `reason` is given."""
    if reason:
        return {p.name: Verdict(NOT_IDENTIFIABLE, reason) for p in parameters}
    return {p.name: _verdict(p, float(s)) for p, s in zip(parameters, std, strict=True)}


def _verdict(p: Parameter, std: float) -> Verdict:
    word = word_of(p.value, std)
    if word == IDENTIFIABLE:
        return Verdict(word, f"known to {100 * std / abs(p.value):.2g} %")
    if word == WEAK:
        return Verdict(word, f"only {abs(p.value) / std:.1f} times its standard error")
    if word == NEGATIVE:
        return Verdict(word, "no skin of this model has that; check signs and gains, and for delays between the channels")
    return Verdict(word, "not told from zero by these data: the force hardly varies at the frequencies where this matters")
