"""Two columns of an array that are exchanged in all sessions: a taxel then stands where another one is declared to be.

A pair of taxels i, j is asked where exchanging their slopes g (S, T) brings them nearer to the declared layout s (S, T), with one free
scale for every session,

    sum over sessions of  1 - (s . g)^2 / (|s|^2 |g|^2),      s . g -> s . g - (s_i - s_j) (g_i - g_j).

An exchange is believed where the analysis of the ratios, with it, is more probable by far than with the best of all causes without it, and
leaves little of what that leaves. Columns are then put right, so that everything else is judged as it was meant.
"""

from dataclasses import dataclass, replace

import numpy as np

from skin_ident.criticism.array.family import Family
from skin_ident.criticism.array.gains import Gains
from skin_ident.criticism.array.judgement import Judged, judge
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.spreading import loads
from skin_ident.criticism.telemetry.symptom import Symptom

NEARER = 0.7  # of that sum, from which an exchange is asked for
ASKED = 3  # pairs
PRIOR = 0.02  # of any exchange, shared by all pairs
SURE = 10.0  # log odds against the best other cause
MENDS, SEEN = 0.25, 0.02  # of what that cause leaves, and what it must leave of the shares
BLOCKS = 10  # of a session, for the covariance of its slopes
ROUGH, FREE = 0.01, 0.05  # relative errors of raw slopes: one by one, and all of a session together


@dataclass(frozen=True)
class _Told:
    """How probable the slopes are in an order of the columns (log), what the best cause leaves of them, relative, and its name."""

    log: float
    left: float
    cause: str


def put_right(recordings: list, layout: Layout | str) -> tuple[list, tuple[Symptom, ...]]:
    """The recordings with the columns of one pair of taxels exchanged in all of them, where that is sure, and what was wrong."""
    if isinstance(layout, str) or len(recordings[0].taxels) < 3:
        return recordings, ()
    declared = Family(layout).shares({})
    measured = _measured(recordings, declared)
    pairs = _pairs(declared, measured.value)
    if not pairs:
        return recordings, ()
    thickness, n = recordings[0].declared.skin_thickness_mm, len(recordings[0].taxels)
    plain = _told(layout, measured, thickness)
    every = [(_told(layout, _in_order(measured, _order(n, pair)), thickness), pair) for pair in pairs]
    best, pair = max(every, key=lambda q: q[0].log)
    odds = best.log - plain.log + np.log(PRIOR / (0.5 * n * (n - 1)))
    if odds < SURE or plain.left < SEEN or best.left > MENDS * plain.left:
        return recordings, ()
    order = _order(n, pair)
    return [replace(r, taxels=r.taxels[order]) for r in recordings], (_symptom(pair, plain, best, float(odds)),)


def _pairs(s: np.ndarray, g: np.ndarray) -> list[tuple[int, int]]:
    """The pairs whose exchange brings slopes and declared shares, (S, T), nearest to each other; none where they agree as they are."""
    scale = np.maximum((s**2).sum(axis=1) * (g**2).sum(axis=1), 1e-300)[:, None]
    i, j = np.triu_indices(s.shape[1], 1)
    together = np.sum(s * g, axis=1)[:, None]
    now = float(np.sum(1.0 - together**2 / scale))
    then = np.sum(1.0 - (together - (s[:, i] - s[:, j]) * (g[:, i] - g[:, j])) ** 2 / scale, axis=0)
    return [(int(i[k]), int(j[k])) for k in np.argsort(then)[:ASKED] if then[k] < NEARER * now]


def _measured(recordings: list, declared: np.ndarray) -> Gains:
    """Elastic slopes of all taxels in every session, with covariances that are generous, each session scaled to be as large as its
    `declared` shares (S, T): no skin is linear, and sessions go to different depths."""
    found = [_slopes(r) for r in recordings]
    scale = [np.linalg.norm(s) / max(np.linalg.norm(g), 1e-300) for s, (g, _) in zip(declared, found, strict=True)]
    return Gains(
        np.array([k * g for k, (g, _) in zip(scale, found, strict=True)]),
        np.array([k * k * c for k, (_, c) in zip(scale, found, strict=True)]),
    )


def _slopes(r) -> tuple[np.ndarray, np.ndarray]:
    """Slopes (T,) on depth and speed in contact (on force, where that drives the test), and their covariance (T, T) from blocks."""
    H = loads(r)
    inverse = np.linalg.pinv(H.T @ H)
    slopes = inverse @ (H.T @ r.taxels.T)
    left = r.taxels.T - H @ slopes
    scores = np.array([inverse[0] @ (h.T @ e) for h, e in zip(np.array_split(H, BLOCKS), np.array_split(left, BLOCKS), strict=True)])
    g = slopes[0]
    rough = (ROUGH * np.abs(g).max()) ** 2 * np.eye(g.size) + FREE**2 * np.outer(g, g)
    return g, scores.T @ scores * BLOCKS / (BLOCKS - 1) + rough


def _order(n: int, pair: tuple[int, int]) -> np.ndarray:
    order = np.arange(n)
    order[list(pair)] = order[list(pair[::-1])]
    return order


def _in_order(measured: Gains, order: np.ndarray) -> Gains:
    return Gains(measured.value[:, order], measured.covariance[:, order][:, :, order])


def _told(layout: Layout, measured: Gains, thickness_mm: float | None) -> _Told:
    judgement = judge(layout, measured, thickness_mm)
    best = max((judgement.nothing, *judgement.causes), key=lambda j: j.log_odds)
    nothing = judgement.nothing.fit.log_evidence + float(np.log(judgement.nothing.background.weight))
    return _Told(nothing + best.log_odds, _left(layout, measured, best), best.hypothesis.cause)


def _left(layout: Layout, measured: Gains, j: Judged) -> float:
    """What a cause leaves of the slopes, each session scaled by itself, as a part of them."""
    s, g = Family(layout).shares(j.fit.member), measured.value
    scale = np.sum(s * g, axis=1) / np.maximum(np.sum(s**2, axis=1), 1e-300)
    return float(np.linalg.norm(g - scale[:, None] * s) / max(np.linalg.norm(g), 1e-300))


def _symptom(pair: tuple[int, int], plain: _Told, best: _Told, odds: float) -> Symptom:
    channels = tuple(f"taxel_{i}" for i in pair)
    other = f"the best other cause ({plain.cause})" if plain.cause else "the declared layout"
    why = (
        f"columns of {channels[0]} and {channels[1]} are exchanged, or their places in taxel_positions_mm: with them the other way round "
        f"{100.0 * best.left:.2g} % of the ratios is left unexplained, and {100.0 * plain.left:.2g} % with {other} as they are. They are "
        "judged the other way round"
    )
    return Symptom("data_error", "taxel", channels, {}, {"why": why, "kind": "exchanged columns", "log_odds": odds})
