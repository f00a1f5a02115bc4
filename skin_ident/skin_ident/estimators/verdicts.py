"""Whether a parameter can be trusted, in newtons: the size of its term, relative to its standard error."""

from collections.abc import Mapping

import numpy as np

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import AT_BOUND, FIXED, IDENTIFIABLE, NEGATIVE, NOT_IDENTIFIABLE, POOR, WEAK, Residual, Verdict
from skin_ident.estimators.regression import Block, regress
from skin_models.parameter import Parameter
from skin_models.signals import GRAVITY

SURE, VAGUE = 0.1, 0.5  # ratio of standard error to value: up to SURE a parameter is identifiable, above VAGUE it is not
REACHED = 0.1  # a channel counts for a parameter if it holds at least this share of the parameter's largest term in any channel
INERTIAL = 0.1  # least ratio of acceleration to gravity (rms) in the mass's column for the mass to be identifiable

DELAYED = "no skin pushes less the faster it is pressed; check for delays between the channels"
REVERSED = "what was measured falls while the skin is pressed; check signs"
MORE = "the taxels feel more than is applied, which no model of the thesis can; check the gains of taxels and load cell"
AGAINST = {"b1": DELAYED, "k1": REVERSED, "b2": f"{MORE}, and delays between them", "k2": MORE}  # what a negative value says


def judge(sessions, shape, parameters: tuple[Parameter, ...], covariance: np.ndarray):
    """Verdicts by parameter, and the rms (N) of each parameter's term by channel."""
    std = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    rms = _column_rms(sessions)
    contributions = {p.name: _carried(p, parameters, shape, rms) for p in parameters}
    verdicts = {p.name: _verdict(p, s, contributions[p.name], shape) for p, s in zip(parameters, std, strict=True)}
    if shape.free:
        verdicts["m"] = _of_mass(sessions, parameters[0], std[0])
    return verdicts, contributions


def where_explained(
    verdicts: Mapping[str, Verdict], contributions: Mapping[str, Mapping[str, float]], residuals: Mapping[str, Residual]
) -> dict[str, Verdict]:
    """The verdicts, with a parameter not identifiable where it acts on a channel that the model explains poorly.

    A taxel that the plunger hardly reaches does not count for parameters that other channels determine.
    """
    poor = {name: r.r2 for name, r in residuals.items() if r.r2 < POOR}
    out = dict(verdicts)
    for name, verdict in verdicts.items():
        carried = contributions[name]
        bad = [channel for channel, newtons in carried.items() if channel in poor and newtons >= REACHED * max(carried.values())]
        if bad and verdict.word in (IDENTIFIABLE, WEAK, NEGATIVE):
            share = f"only {100 * poor[bad[0]]:.0f} %" if poor[bad[0]] > 0.0 else "nothing"
            out[name] = Verdict(NOT_IDENTIFIABLE, f"the model explains {share} of {bad[0]}: this number is no property of the skin")
    return out


def negative(words: Mapping[str, str]) -> list[str]:
    """A warning for every parameter that is called negative, by the words of the verdicts."""
    return [f"{name} is negative: {AGAINST.get(name, REVERSED)}" for name, word in words.items() if word == NEGATIVE]


def mass_at_bound() -> Verdict:
    """The verdict on a mass that came out negative."""
    return Verdict(AT_BOUND, "it came out negative and was set to 0: what it would have carried is a constant force, not inertia")


def _column_rms(sessions) -> dict[str, float]:
    columns = np.concatenate([s.columns() for s in sessions])
    return dict(zip(("v", "x", "a", "g"), np.sqrt(np.mean(columns**2, axis=0)), strict=True))


def _carried(p: Parameter, parameters: tuple[Parameter, ...], shape, rms: dict[str, float]) -> dict[str, float]:
    """Rms (N) of the parameter's term in every channel that it acts on."""
    values = {q.name: q.value for q in parameters}
    if p.name == "m":
        return {"force": abs(p.value) * float(np.hypot(rms["a"], rms["g"]))} if shape.force else {}
    if p.name.startswith("share_"):
        sensed = np.hypot(values["b1"] * rms["v"], values["k1"] * rms["x"])
        return {f"taxel_{p.name[6:]}": float(p.value * sensed)}
    size = abs(p.value) * rms["v" if p.name[0] == "b" else "x"]
    force = {"force": float(size)} if shape.force else {}
    if p.name in ("b2", "k2"):
        return force
    return force | {f"taxel_{i}": float(values[f"share_{i}"] * size) for i in shape.live}


def word_of(value: float, std: float) -> str:
    """The word for how well a parameter is known, by the ratio of its standard error to its value; one for what no skin has comes first."""
    relative = std / abs(value) if value else np.inf
    if value < 0.0 and relative <= VAGUE:
        return NEGATIVE
    return IDENTIFIABLE if relative <= SURE else WEAK if relative <= VAGUE else NOT_IDENTIFIABLE


def _verdict(p: Parameter, std: float, carried: dict[str, float], shape) -> Verdict:
    if p.name == "m":
        return Verdict(FIXED, "held at the value that was given")
    if p.name in ("b2", "k2") and not (shape.force and shape.taxels):
        why = "the load cell is missing" if shape.taxels else "there is no taxel: b1 and k1 stand for the whole skin"
        return Verdict(NOT_IDENTIFIABLE, f"{why}, so what is dispersed cannot be told from what is sensed; set to 0")
    if p.name.startswith("share_") and int(p.name[6:]) not in shape.live:
        return Verdict(NOT_IDENTIFIABLE, "this taxel never changes, or is in volts: nothing is known of it, and the model leaves it silent")
    if std == 0.0 and p.name.startswith("share_") and p.value == 1.0:
        return Verdict(FIXED, "1 by definition: shares are relative to the strongest taxel")
    relative = std / abs(p.value) if p.value else np.inf
    newtons = max(carried.values(), default=0.0)
    size = f"its term carries {newtons:.3g} N rms, known to {newtons * min(relative, 99.0):.2g} N"
    word = word_of(p.value, std)
    if word == IDENTIFIABLE:
        return Verdict(word, size)
    if word == NEGATIVE:
        return Verdict(word, f"{size}: {AGAINST[p.name]}")
    only = f"only {1 / relative:.1f} times its standard error" if word == WEAK else "not told from zero by these data"
    return Verdict(word, f"{size}: {only}")


def _of_mass(sessions, m: Parameter, std: float) -> Verdict:
    """The verdict on a free mass. Its column is split into acceleration and gravity, since only the former shows inertia."""
    rms = _column_rms(sessions)
    constant, inertial = m.value * rms["g"], m.value * rms["a"]
    alone, alone_std = _by_acceleration(sessions)
    if rms["a"] >= INERTIAL * rms["g"]:
        return Verdict(word_of(m.value, std), f"acceleration carries {inertial:.3g} N rms beside {constant:.3g} N of gravity")
    return Verdict(
        NOT_IDENTIFIABLE,
        f"its column is constant gravity: -m g carries {constant:.3g} N, acceleration only {inertial:.2g} N rms, so this number stands "
        f"for a constant force of {-m.value * GRAVITY:.3g} N (wrong zero of depth or force, preload, or curvature of the spring), not "
        f"for inertia; {_said_by_acceleration(alone, alone_std)}",
    )


def _said_by_acceleration(mass: float, std: float) -> str:
    if not np.isfinite(std):
        return "acceleration by itself says nothing: on one sine it is depth over again, less a constant"
    return f"acceleration by itself says m = {mass:.2g} ± {std:.2g} kg"


def _by_acceleration(sessions) -> tuple[float, float]:
    """The mass (kg) and its standard error from acceleration alone, with a separate free coefficient for the constant part."""
    blocks = []
    for s in sessions:
        v, x, a, g = s.columns().T
        columns = np.column_stack([a, g, v, x])
        blocks += [Block(s.force[part], columns[part], s.prefilter.kernel) for part in s.parts]
    try:
        fit = regress([blocks])
    except FitError:
        return np.nan, np.inf
    return float(fit.coefficients[0][0]), float(np.sqrt(fit.covariance[0, 0]))
