"""What each session says by itself, so that a change from one day to another is seen where it happened.

The model is fitted once more to each session alone: its stiffnesses, dampings and shares, with the named causes as they are and without
what was found to belong to this session (a gain, a zero, a skin of its own). Zeros of all channels are fitted too. With the tangents J of
the model, columns of ones for each channel in Z, and the residual r,

    [dp, z] = argmin |W (r - J dp - Z z)|^2,    covariance s^2 ([J Z]' W' W [J Z])^-1

with the whitening W of the search. The numbers of one session are compared with those of the others by median and median absolute
deviation, which one odd session does not move (F. R. Hampel, J. Am. Stat. Assoc. 69 (1974) 383-393).
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import t as student

from skin_ident.criticism.baseline.fitting import tangents
from skin_ident.criticism.baseline.residual import damping, placed, residual, rmse, stiffness
from skin_ident.criticism.baseline.unknowns import Unknown, scales, those_told, unknowns, values, with_values
from skin_ident.criticism.noise.whitening import Whitener, stack
from skin_ident.criticism.search.named import Criticism
from skin_ident.criticism.sessions.session import FITTED, KEPT, Session, with_reference
from skin_ident.estimators.scale import normal_scale
from skin_models.model import Model

TURNS = 2  # Gauss-Newton steps: apart from the shares the model is linear in its parameters
STEP = 1e-4  # of finite differences, in scaled unknowns
TELLS = 0.3  # largest relative standard error with which a number is reported
MOST = 0.3  # share of a session's samples that must be trusted in a channel
TINY = 1e-9  # N, and relative: next to nothing
FEWEST = 4  # sessions needed for one to stand out
CHANCE = 1e-3  # probability that a number of a sound session stands out
STANDS_OUT = {"stiffness": 0.005, "ratio": 0.005, "recovery": 0.05, "zero": 0.0}  # least relative difference with which a number stands out
ALIKE = 0.1  # relative difference between the RMS errors of sessions of one kind
MOST_OF_IT = 1.6  # ratio of RMS residuals above which one session, or some, stand above all others


Number = tuple[float, float]  # a value and its standard error
_Alone = dict[str, dict[str, Number]]  # numbers of one session by kind and channel

UNITS = {"stiffness": "N/m", "ratio": "1", "recovery": "s", "zero": "N"}


def by_session(c: Criticism, plain: list[Session]) -> dict[str, dict[str, Any]]:
    """What each session says by itself, by name, as an entry of `recordings` in findings.json holds it: `by_itself`, `rmse` of baseline and
    extended model, and the numbers in which it `stands_out`. `plain` are the sessions in the order of `c.train` and `c.held`, without what
    was found to be their own. {} for a lone session, which was criticised in two parts."""
    sessions = [*c.train, *c.held]
    if any(s.name.endswith((FITTED, KEPT)) for s in sessions):
        return {}
    bare = [with_reference([replace(s, beyond=p.beyond, skin={}, reference=None)])[0] for s, p in zip(sessions, plain, strict=True)]
    own = [_alone(c.extended.model, s, c.last.noise) for s in bare]
    before = [rmse([residual(c.baseline.model, c.before(s))], [s]) for s in sessions]
    after = [rmse([residual(c.extended.model, s)], [s]) for s in sessions]
    errors = [
        {ch: {"baseline": b[ch], "extended": a[ch], "unit": "N"} for ch in s.channels if s.weight[s.channels.index(ch)].any()}
        for s, b, a in zip(sessions, before, after, strict=True)
    ]
    odd = list(_odd(own, errors))
    return {
        s.name: {"by_itself": _quantities(o), "rmse": e, "stands_out": [what for what, sessions in odd if i in sessions]}
        for i, (s, o, e) in enumerate(zip(sessions, own, errors, strict=True))
    }


def most_left(told: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """The sessions with the largest residual: their names (`most_in`), the `channel` in which they stand out most, and the ratio of their
    RMS residual to that of the others (`times`). `told` is the result of `by_session`. {} where none stand out."""
    channels = dict.fromkeys(channel for e in told.values() for channel in e["rmse"])
    of_each = {c: {n: e["rmse"][c]["extended"] for n, e in told.items() if c in e["rmse"]} for c in channels}
    found = [{"most_in": names, "channel": c, "times": times} for c, left in of_each.items() for names, times in louder_than_others(left)]
    return max(found, key=lambda m: m["times"], default={})


def louder_than_others(left: Mapping[str, float]) -> Iterator[tuple[list[str], float]]:
    """The sessions whose RMS residual is clearly larger than that of all others, and the ratio of the two; nothing where there are none."""
    names = sorted(left, key=lambda n: -left[n])
    rms = np.array([max(left[n], TINY) for n in names])
    gaps = rms[:-1] / rms[1:]
    if len(names) >= FEWEST and gaps[: len(names) - 2].max() > MOST_OF_IT:
        k = int(np.argmax(gaps[: len(names) - 2])) + 1
        yield [n for n in left if n in names[:k]], float(np.sqrt(np.mean(rms[:k] ** 2) / np.mean(rms[k:] ** 2)))


@dataclass(frozen=True)
class _Fitted:
    """The `model` with the unknowns `which` fitted to one session, the `zeros` (C,), N, and the `covariance` of both, scaled unknowns
    first."""

    model: Model
    which: tuple[Unknown, ...]
    zeros: np.ndarray
    covariance: np.ndarray

    def number(self, of: Callable[[Model], float]) -> Number:
        """A function of the model and its standard error, by linear propagation."""
        theta, scale, here = values(self.model, self.which), scales(self.model, self.which), of(self.model)
        moved = [of(with_values(self.model, self.which, theta + STEP * scale * row)) for row in np.eye(theta.size)]
        slopes = (np.array(moved) - here) / STEP
        return float(here), float(np.sqrt(max(slopes @ self.covariance[: theta.size, : theta.size] @ slopes, 0.0)))

    def zero(self, c: int) -> Number:
        """The zero of a channel, N, and its standard error."""
        return float(self.zeros[c]), float(np.sqrt(max(np.diag(self.covariance)[len(self.which) + c], 0.0)))


def _fitted(model: Model, s: Session, noise: Whitener, which: tuple[Unknown, ...], heard: list[str]) -> _Fitted:
    """Solve the module's equation on the channels `heard`."""
    mask = np.array([channel in heard for channel in s.channels])[:, None]
    s = replace(s, weight=np.where(mask, s.weight, 1.0))  # unheard channels are masked below and must not blank others
    ones = np.eye(len(s.channels))[:, :, None] * np.ones(s.t.size)
    for _ in range(TURNS):
        J = stack([np.concatenate([tangents(model, [s], which)[0], ones]) * mask], [s], noise)
        r = noise.apply(residual(model, s) * mask, s).ravel()
        found = np.linalg.lstsq(J, r, rcond=None)[0]
        model = with_values(model, which, values(model, which) + found[: len(which)] * scales(model, which))
    left, free = r - J @ found, int(np.count_nonzero(r)) - len(found)
    covariance = np.linalg.pinv(J.T @ J) * float(left @ left) / max(free, 1)
    return _Fitted(model, which, found[len(which) :], covariance)


def _alone(model: Model, s: Session, noise: Whitener) -> _Alone:
    """The numbers that a session determines by itself, from the channels that are trusted."""
    strongest = f"taxel_{int(np.argmax(placed(model, s).shares))}" if model.shares else ""
    heard = _heard(s)
    pressing = ["force"] if "force" in heard or s.drive is not None else []
    known = {*pressing, *heard}
    fitted = _fitted(model, s, noise, those_told(unknowns(model, s), model, lambda u: _is_determined(u, known, strongest)), heard)
    told = [*pressing, *(channel for channel in (strongest,) if channel in heard)]

    def number(of: Callable[[Model, str], float], channel: str) -> Number:
        return fitted.number(lambda m: of(placed(m, s), channel))

    stiff = {} if s.drive is not None else {channel: number(stiffness, channel) for channel in told}
    ratio = {strongest: number(force_over, strongest)} if {"force", strongest} <= set(stiff) else {}
    slow = {channel: number(recovery, channel) for channel in told}
    zeros = {channel: fitted.zero(c) for c, channel in enumerate(s.channels) if channel in heard}
    return {
        "stiffness": {channel: q for channel, q in stiff.items() if 0.0 < q[1] < TELLS * abs(q[0])},
        "ratio": {channel: q for channel, q in ratio.items() if 0.0 < q[1] < TELLS * abs(q[0])},
        "recovery": {channel: q for channel, q in slow.items() if 0.0 < q[1] < max(TELLS * abs(q[0]), s.period)},
        "zero": {channel: q for channel, q in zeros.items() if q[1] > 0.0},
    }


def _heard(s: Session) -> list[str]:
    """Channels that are trusted for most of a session and not stuck."""
    return [c for c, w in zip(s.channels, s.weight, strict=True) if np.mean(w > 0.0) > MOST and c not in s.stuck]


def _is_determined(u: Unknown, known: set[str], strongest: str) -> bool:
    """Whether the channels that are `known` determine an unknown of the plain model: taxels the sensed branch (k1, b1), the force the
    dispersed one (k2, b2), and a taxel its share beside that of the `strongest`, which is 1; without this one the shares are held."""
    if u.part == "shares":
        return {strongest, f"taxel_{u.parameter.name}"} <= known
    taxels, force = known - {"force"}, known & {"force"}
    return u.part == "dispersion" and bool({"b1": taxels, "k1": taxels, "b2": force, "k2": force}.get(u.label))


def force_over(model: Model, channel: str) -> float:
    """Stiffness of the force over that of a channel: a gain error changes it, a skin that is stiffer as a whole does not. nan where the
    channel feels nothing."""
    return _ratio(stiffness(model, "force"), stiffness(model, channel))


def recovery(model: Model, channel: str) -> float:
    """Recovery time b / k of a channel, s; nan where it feels nothing."""
    return _ratio(damping(model, channel), stiffness(model, channel))


def _ratio(a: float, b: float) -> float:
    return a / b if b > TINY * abs(a) else float("nan")


def _quantities(own: _Alone) -> dict[str, Any]:
    return {
        kind: {channel: {"value": value, "unit": UNITS[kind], "std": std} for channel, (value, std) in of.items()}
        for kind, of in own.items()
    }


def _odd(own: list[_Alone], errors: list[dict[str, Any]]) -> Iterator[tuple[str, set[int]]]:
    """For every number (`kind.channel`), the indices of the sessions in which it stands out."""
    for kind in UNITS:
        for channel in dict.fromkeys(channel for o in own for channel in o[kind]):
            told = {i: o[kind][channel] for i, o in enumerate(own) if channel in o[kind]}
            y, std = np.array([*told.values()]).T
            yield f"{kind}.{channel}", {i for i, out in zip(told, standing_out(y, std, STANDS_OUT[kind]), strict=True) if out}
    for channel in dict.fromkeys(channel for e in errors for channel in e):
        told = {i: np.log(max(e[channel]["extended"], TINY)) for i, e in enumerate(errors) if channel in e}
        y = np.array([*told.values()])
        out = standing_out(y, np.full(y.size, ALIKE)) & (y > np.median(y) + np.log(MOST_OF_IT))
        yield f"rmse.{channel}", {i for i, o in zip(told, out, strict=True) if o}


def standing_out(y: np.ndarray, std: np.ndarray, least: float = 0.0) -> np.ndarray:
    """Mask (S,) of the numbers whose distance from the median exceeds both what scatter and standard errors account for and the share
    `least` of the median."""
    if y.size < FEWEST:
        return np.zeros(y.size, bool)
    middle = float(np.median(y))
    scatter = np.hypot(np.hypot(normal_scale(y - middle), np.median(std)), std)
    limit = float(student.isf(0.5 * CHANCE, y.size - 2))
    return np.abs(y - middle) > np.maximum(limit * scatter, least * abs(middle))
