"""Two exchanged columns of an array, in all sessions or in one: each taxel then appears at the declared place of the other.

A pair of taxels i, j is a candidate if exchanging their slopes g (S, T) brings these nearer to the declared shares s (S, T), with a free
scale for every session:

    sum over sessions of  1 - (s . g)^2 / (|s|^2 |g|^2),      s . g -> s . g - (s_i - s_j) (g_i - g_j).

An exchange in one session alone is considered where sessions press at different places; at one place the other sessions show the right
order (`telemetry.odd_session`). An exchange is accepted if the analysis of the ratios is far more probable with it than with the best cause
without it, and if it removes most of what that cause leaves. The columns are then corrected, so that everything else is judged in the right
order.
"""

from dataclasses import dataclass

import numpy as np

from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains
from skin_ident.criticism.array.judgement import judge, unlike
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.spreading import beside_zero
from skin_ident.criticism.telemetry.symptom import Symptom
from skin_ident.criticism.vocabulary import EXCHANGED

NEARER = 0.7  # ratio of that sum after to before an exchange, below which the exchange is a candidate
ASKED = 3  # candidates at most
PRIOR = 0.02  # prior probability of any exchange, divided among all possible ones
SURE = 10.0  # log odds needed against the best cause without exchange
MENDS, SEEN = 0.25, 0.02  # share of that cause's misfit that may remain, and its least relative misfit
BLOCKS = 10  # blocks of a session, for the covariance of its slopes
ROUGH, FREE = 0.01, 0.05  # relative standard errors added to raw slopes: independent ones, and one common to a session


@dataclass(frozen=True)
class _Told:
    """The log probability of the slopes in one order of the columns, and the relative misfit and the name of the best cause."""

    log: float
    left: float
    cause: str


@dataclass(frozen=True)
class _Exchange:
    """Exchange of the columns of a pair of taxels, in one session or (None) in all."""

    pair: tuple[int, int]
    session: int | None = None

    def of(self, n: int, session: int) -> np.ndarray:
        """The order (n,) of the n columns of a session."""
        order = np.arange(n)
        if self.session in (None, session):
            order[list(self.pair)] = order[list(self.pair[::-1])]
        return order


def put_right(recordings: list, layout: Layout | str) -> tuple[list, tuple[Symptom, ...]]:
    """The recordings with the columns of one pair of taxels exchanged where that is certain, and the symptom."""
    if isinstance(layout, str) or len(recordings[0].taxels) < 3:
        return recordings, ()
    declared = Family(layout).shares({})
    measured = _measured(recordings, declared)
    asked = _asked(declared, measured.value, layout.several_contacts)
    if not asked:
        return recordings, ()
    thickness, n = recordings[0].declared.skin_thickness_mm, len(recordings[0].taxels)
    plain = _told(layout, measured, thickness)
    every = [(_told(layout, _in_order(measured, x), thickness), x) for x in asked]
    best, found = max(every, key=lambda q: q[0].log)
    ways = 0.5 * n * (n - 1) * (1 + len(recordings) * layout.several_contacts)
    odds = best.log - plain.log + np.log(PRIOR / ways)
    if odds < SURE or plain.left < SEEN or best.left > MENDS * plain.left:
        return recordings, ()
    where = None if found.session is None else recordings[found.session].name
    right = [_written_as(r, found.of(n, i)) for i, r in enumerate(recordings)]
    return right, (_symptom(found.pair, where, plain, best, float(odds)),)


def _written_as(r, order: np.ndarray):
    """The recording with its columns in this order, under unchanged column names."""
    return r.with_taxels(order, taxel_names=r.taxel_names, taxel_units=r.taxel_units)


def _asked(s: np.ndarray, g: np.ndarray, one_by_one: bool) -> list[_Exchange]:
    """The candidates: exchanges that bring slopes and declared shares, (S, T), nearest to each other; none where no exchange helps
    enough."""
    scale = np.maximum((s**2).sum(axis=1) * (g**2).sum(axis=1), 1e-300)[:, None]
    i, j = np.triu_indices(s.shape[1], 1)
    together = np.sum(s * g, axis=1)[:, None]
    now = 1.0 - together**2 / scale
    then = 1.0 - (together - (s[:, i] - s[:, j]) * (g[:, i] - g[:, j])) ** 2 / scale
    pairs = [(int(a), int(b)) for a, b in zip(i, j, strict=True)]
    left = {_Exchange(pair): float(then[:, k].sum()) for k, pair in enumerate(pairs)}
    if one_by_one:
        gained = then - now
        left |= {_Exchange(p, at): float(now.sum() + gained[at, k]) for k, p in enumerate(pairs) for at in range(len(s))}
    return [x for x in sorted(left, key=left.get)[:ASKED] if left[x] < NEARER * now.sum()]


def _measured(recordings: list, declared: np.ndarray) -> Gains:
    """Elastic slopes of all taxels in every session with generous covariances. Each session is scaled to the norm of its `declared` shares
    (S, T), since no skin is linear and sessions go to different depths."""
    found = [_slopes(r) for r in recordings]
    scale = [np.linalg.norm(s) / max(np.linalg.norm(g), 1e-300) for s, (g, _) in zip(declared, found, strict=True)]
    return Gains(
        np.array([k * g for k, (g, _) in zip(scale, found, strict=True)]),
        np.array([k * k * c for k, (_, c) in zip(scale, found, strict=True)]),
    )


def _slopes(r) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (T,) on depth and speed in contact (on force, where that drives the test), beside a zero of each taxel, and their covariance
    (T, T) from blocks."""
    H = beside_zero(r)
    inverse = np.linalg.pinv(H.T @ H)
    slopes = inverse @ (H.T @ r.taxels.T)
    left = r.taxels.T - H @ slopes
    scores = np.array([inverse[0] @ (h.T @ e) for h, e in zip(np.array_split(H, BLOCKS), np.array_split(left, BLOCKS), strict=True)])
    g = slopes[0]
    rough = (ROUGH * np.abs(g).max()) ** 2 * np.eye(g.size) + FREE**2 * np.outer(g, g)
    return g, scores.T @ scores * BLOCKS / (BLOCKS - 1) + rough


def _in_order(measured: Gains, x: _Exchange) -> Gains:
    orders = [x.of(measured.value.shape[1], i) for i in range(len(measured.value))]
    return Gains(
        np.array([row[o] for row, o in zip(measured.value, orders, strict=True)]),
        np.array([c[np.ix_(o, o)] for c, o in zip(measured.covariance, orders, strict=True)]),
    )


def _told(layout: Layout, measured: Gains, thickness_mm: float | None) -> _Told:
    judgement = judge(layout, measured, thickness_mm)
    best = max((judgement.nothing, *judgement.causes), key=lambda j: j.log_odds)
    nothing = judgement.nothing.fit.log_evidence + float(np.log(judgement.nothing.background.weight))
    return _Told(nothing + best.log_odds, unlike(layout, measured, best), best.hypothesis.cause)


def _symptom(pair: tuple[int, int], session: str | None, plain: _Told, best: _Told, odds: float) -> Symptom:
    channels = tuple(f"taxel_{i}" for i in pair)
    other = f"the best other cause ({plain.cause})" if plain.cause else "the declared layout"
    where = f" in {session} alone" if session else ", or their places in taxel_positions_mm"
    why = (
        f"columns of {channels[0]} and {channels[1]} are exchanged{where}: with them the other way round "
        f"{100.0 * best.left:.2g} % of the ratios is left unexplained, and {100.0 * plain.left:.2g} % with {other} as they are. They are "
        "judged the other way round"
    )
    evidence = {"why": why, "kind": EXCHANGED, "log_odds": odds, **({"session": session} if session else {})}
    return Symptom("data_error", "taxel", channels, {}, evidence)
