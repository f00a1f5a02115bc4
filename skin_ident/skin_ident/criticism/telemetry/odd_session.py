"""Single sessions that differ from most others as a whole: columns that are swapped, a sign, or a unit.

A channel's slope against the load differs from session to session, because skins are not linear. The ratio of two channels' slopes does
not, as long as the sessions press at one place. So with slopes S (sessions, channels), and those of the other sessions by their median, a
session is odd where

    its shares S_i / |S_i| are those of the others in another order                          (columns)
    log |S_ic| less that of the others, less the same of its other channels, is log f        (f a factor of units)
    it falls while the load rises, and rises with it in two others or more                   (sign)
    a taxel changes by far more than the force, and by no more than it in all others         (a unit, wherever the sessions press)
    all its channels' slopes are f times those of the others, and its range of depth 1 / f   (the depth in another unit of length).

Such a session is corrected, so that the rest of it can be judged, and the finding reports the correction.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from skin_ident.criticism.pattern import in_sessions, when
from skin_ident.criticism.telemetry.more_than_applied import in_newtons
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.telemetry.units import (
    AGAINST,
    FACTORS,
    FOLLOWS,
    NEAR_FACTOR,
    by_grid,
    follows,
    load_of,
    pressed,
    presses_elsewhere,
    told_signs,
)
from skin_ident.criticism.vocabulary import SWAPPED, UNIT_FACTOR
from skin_ident.quality import FAR_TOO_MUCH, MOST_FELT

ODD = 0.15  # distance of two unit vectors of shares from which another order is tried
MENDS = 0.25  # greatest distance left in the other order, as a share of the original one
LITTLE, EXACTLY = 0.02, 0.1  # the same limits for much the same columns, if the others agree: no two gains would change so as to fit
ALIKE = 0.05  # distance that may also be left, as shares differ by so much from day to day
DEEPER = 5.0  # factor by which sessions of one skin may differ in stiffness and in depth
HUGE, WIDE = 100.0, 2.0  # a unit factor beyond HUGE is recognised within a factor of WIDE
ORDERLY = 0.3  # share of a factor's logarithm by which the other sessions may differ among themselves
LENGTHS = (1e3, 1e-3, 1e6, 1e-6)  # m, mm and µm for one another: no skin is so much stiffer than itself
OTHERS = (25.4, 1 / 25.4, 10.0, 0.1, 100.0, 0.01)  # inches, centimetres and hundredths of a millimetre
CLOSELY = 1.25  # factor within which it must be one of `OTHERS`: skins differ by as much, but hardly ever by exactly that
USUAL = 1e-3  # m, a usual depth: of two sessions the one further from it is the odd one
DECIMAL = 1e-4  # error allowed in the decimal logarithm of a power of ten
THOUSAND = 1e3  # millinewtons in a newton
MOST = 6  # faults that are corrected in the sessions at one place


@dataclass(frozen=True)
class _Fault:
    """The symptom, the index of the session that has it, and that session corrected."""

    symptom: Symptom
    session: int
    right: object


def put_right(recordings: list) -> tuple[list, tuple[Symptom, ...]]:
    """The recordings with every odd session corrected, and the symptoms. A session that is alone at its place is tested only for signs, and
    for units that its converter steps prove or that are off by a thousand."""
    recordings, scaled = _in_newtons(list(recordings))
    recordings, turned = _upright(recordings)
    symptoms = [*scaled, *turned]
    for group in _places(recordings):
        for _ in range(MOST):
            fault = _fault([recordings[i] for i in group])
            if fault is None:
                break
            symptoms.append(fault.symptom)
            recordings[group[fault.session]] = fault.right
    recordings, thousandfold = _not_in_thousandths(recordings)
    symptoms += thousandfold
    return recordings, tuple(_together(symptoms, [r.name for r in recordings]))


def _together(symptoms: list[Symptom], names: list[str]) -> Iterator[Symptom]:
    """The symptoms, with those of several sessions that have the same fault merged into one."""
    alike: dict[tuple, list[Symptom]] = {}
    for s in symptoms:
        factor = s.parameters.get("factor", {}).get("value", 1.0)
        fault = s.evidence["kind"], s.channels, bool(factor < 0.0), round(float(np.log10(abs(factor))), 1)
        alike.setdefault(fault, []).append(s)
    for first, *more in alike.values():
        some = [s.evidence["session"] for s in (first, *more) if "session" in s.evidence]
        why = f"{first.evidence['why']}. The same is so {when(some, names)}"
        known = {k: v for k, v in first.evidence.items() if k != "session"}
        yield replace(first, evidence={**known, "why": why, **in_sessions(some, names)}) if len(some) > 1 else first


def _in_newtons(recordings: list) -> tuple[list, list[Symptom]]:
    """Converts channels into newtons if their converter steps prove that they are in another unit in all sessions. A factor of ten proves
    nothing: the converter may be coarser than declared."""
    symptoms = []
    for channel in recordings[0].channels:
        for s in by_grid(recordings, channel):
            factor = s.parameters["factor"]["value"]
            if s.evidence["kind"] == UNIT_FACTOR and abs(np.log10(factor) - np.round(np.log10(factor))) > DECIMAL:
                judged = f"{s.evidence['why']}. It is judged divided by {factor:.5g}"
                symptoms.append(replace(s, evidence={**s.evidence, "why": judged}))
                recordings = [r.scaled({channel: 1.0 / factor}) for r in recordings]
    return recordings, symptoms


def _upright(recordings: list) -> tuple[list, list[Symptom]]:
    """Channels that are upside down in all sessions that tell a sign, if most do, with their sign turned."""
    symptoms = []
    for channel in recordings[0].channels:
        driving = channel == "force" and recordings[0].depth is None
        told = _of_the_drive(recordings) if driving else told_signs(recordings, channel)
        asked = np.isfinite(told)
        if 2 * asked.sum() > len(told) and max(told[asked]) < AGAINST:
            first = int(np.argmax(asked))
            every = "all sessions" if asked.all() else f"each of the {asked.sum()} sessions whose load moves enough to tell"
            falls = "force pulls, and the taxels fall while it rises," if driving else f"{channel} falls while the load rises"
            falls = f"{falls} in {every} (correlation {told[first]:.2f} in {recordings[first].name})"
            evidence = {"why": f"{falls}: its sign is wrong. It is judged with its sign reversed", "kind": "sign"}
            where = sensor_of(channel, len(recordings[0].taxels))
            symptoms.append(Symptom("data_error", where, (channel,), {"factor": quantity(-1.0, "1")}, evidence))
            recordings = [r.scaled({channel: -1.0}) for r in recordings]
    return recordings, symptoms


def _of_the_drive(recordings: list) -> np.ndarray:
    """What tells the sign of a force that drives, for every session (S,): the taxels' correlation with it, by their median, where it pulls
    more than it presses, as no plunger does; NaN elsewhere."""
    taxels = [told_signs(recordings, c) for c in recordings[0].channels if c != "force"]
    return np.where([r.force.min() < -r.force.max() for r in recordings], np.median(taxels, axis=0), np.nan)


def _not_in_thousandths(recordings: list) -> tuple[list, list[Symptom]]:
    """Taxels of a session that change by far more than the force there and by no more than it in all other sessions, divided by a thousand.
    Not where every taxel of the session does: then the force is in another unit."""
    taxels = [i for i in range(len(recordings[0].taxels)) if recordings[0].force is not None and in_newtons(recordings, i)]
    felt = np.array([[_felt(r, f"taxel_{i}") for i in taxels] for r in recordings]).reshape(len(recordings), len(taxels))
    wrong = (felt > FAR_TOO_MUCH) & (felt < THOUSAND * MOST_FELT)
    wrong &= ~np.all(wrong | (felt == 0.0), axis=1, keepdims=True)
    right, symptoms = list(recordings), []
    for i, own, odd in zip(taxels, felt.T, wrong.T, strict=True):
        if odd.all() or max(own[~odd]) > MOST_FELT:
            continue
        for k in np.flatnonzero(odd):
            why = f"taxel_{i} of {recordings[k].name} changes by {own[k]:.3g} N per newton of applied force: a factor of units"
            fault = _of_channel(right, int(k), f"taxel_{i}", THOUSAND, why, UNIT_FACTOR)
            symptoms.append(fault.symptom)
            right[k] = fault.right
    return right, symptoms


def _felt(recording, channel: str) -> float:
    """The slope of a channel over the force, N/N; 0 where it does not follow the load, or there is none."""
    if load_of(recording, channel) is None or abs(follows(recording, channel)) <= FOLLOWS:
        return 0.0
    x = recording.channels["force"] - recording.channels["force"].mean()
    return abs(float(x @ recording.channels[channel] / max(x @ x, 1e-300)))


def _places(recordings: list) -> Iterator[list[int]]:
    """Indices of the sessions that press at one place, for places with two sessions or more. Without those that hold their load, since
    nothing in them can be compared."""
    places: dict[tuple[float, float], list[int]] = {}
    for i, r in enumerate(recordings):
        if all(load_of(r, c) is None for c in r.channels):
            continue
        places.setdefault(tuple(r.declared.contact_of(r.name)), []).append(i)
    yield from (group for group in places.values() if len(group) > 1)


def _fault(group: list) -> _Fault | None:
    names = [c for c in group[0].channels if all(load_of(r, c) is not None for r in group)]
    slopes = np.array([[_slope(r, c) for c in names] for r in group])
    for look in (_deep, _turned, _reordered, _scaled):
        fault = look(group, names, slopes)
        if fault is not None:
            return fault
    return None


def _slope(recording, channel: str) -> float:
    """Least-squares slope in contact, N per metre (per newton, where force drives the test)."""
    x, y = (row[pressed(recording)] for row in (load_of(recording, channel), recording.channels[channel]))
    x = x - x.mean()
    return float(x @ (y - y.mean()) / max(x @ x, 1e-300))


def _turned(group: list, names: list[str], slopes: np.ndarray) -> _Fault | None:
    """A channel that is upside down in a session and upright in most of the others."""
    for channel in names:
        told = told_signs(group, channel)
        wrong, upright, asked = np.flatnonzero(told < AGAINST), np.sum(told > -AGAINST), np.sum(np.isfinite(told))
        if 0 < 2 * len(wrong) < asked == len(wrong) + upright:
            r = group[wrong[0]]
            alone = "alone " if len(wrong) == 1 else ""
            why = f"{channel} falls while the load rises in {r.name} {alone}(correlation {told[wrong[0]]:.2f}): its sign is wrong there"
            return _of_channel(group, int(wrong[0]), channel, -1.0, why, "sign")
    return None


def _scaled(group: list, names: list[str], slopes: np.ndarray) -> _Fault | None:
    """A channel that is in other units in one session."""
    sure = np.array([all(follows(r, c) > FOLLOWS for r in group) for c in names], bool)
    channels = [c for c, q in zip(names, sure, strict=True) if q]
    logs = np.log(np.abs(slopes[:, sure])) if channels else np.empty((len(group), 0))
    found = [(abs(np.log(f)), i, c, f) for i in range(len(group)) for c in range(len(channels)) if (f := _factor(logs, i, c))]
    found = [q for q in found if channels[q[2]] == "force" or not presses_elsewhere(_of_other_taxels(logs, channels, *q[1:3]))]
    if not found:
        return None
    _, i, c, factor = max(found, key=lambda q: (q[0], q[3]))
    say = f"{channels[c]} of {group[i].name} is {np.exp(_beside(logs, i, c)):.4g} times what the other sessions say"
    return _of_channel(group, i, channels[c], factor, f"{say}: a factor of units{_either(group)}", UNIT_FACTOR)


def _deep(group: list, names: list[str], slopes: np.ndarray) -> _Fault | None:
    """A session whose depth is in another unit of length."""
    if group[0].depth is None or not names or not all(follows(r, c) > FOLLOWS for r in group for c in names):
        return None
    stiff = np.log(np.abs(slopes)).mean(axis=1)
    spans = np.log([np.ptp(r.depth) for r in group])
    found = []
    for i in range(len(group)):
        apart, wide = (float(q[i] - np.median(np.delete(q, i))) for q in (stiff, spans))
        found += [(abs(spans[i] - np.log(USUAL)), i, f) for f in (*LENGTHS, *OTHERS) if _is_in_unit(f, apart, wide)]
    if not found:
        return None
    _, i, factor = max(found)
    r = group[i]
    why = (
        f"the depth of {r.name} spans {1e3 * np.ptp(r.depth):.3g} mm, and all its loads grow {1.0 / factor:.4g} times as fast with it as "
        f"those of the other sessions: its unit is wrong. {r.name} is judged with its depth divided by {factor:.5g}"
    )
    evidence = {"why": why, "kind": UNIT_FACTOR, "session": r.name}
    symptom = Symptom("data_error", "rig", ("depth",), {"factor": quantity(factor, "1")}, evidence)
    return _Fault(symptom, i, r.scaled({"depth": 1.0 / factor}))


def _is_in_unit(factor: float, stiffer: float, wider: float) -> bool:
    """Whether a depth is too large by `factor`, from the logarithms of how much stiffer and wider in depth a session is than the others."""
    nearly, about = (DEEPER, DEEPER) if factor in LENGTHS else (CLOSELY, CLOSELY**3)
    return abs(stiffer + np.log(factor)) < np.log(nearly) and abs(wider - np.log(factor)) < np.log(about)


def _factor(logs: np.ndarray, i: int, c: int) -> float | None:
    """The factor of units by which channel `c` of session `i` is too large; None where there is none, or where another channel has it."""
    own, whole = _beside(logs, i, c), logs[i, c] - np.median(np.delete(logs[:, c], i))
    factor = next((f for f in FACTORS if abs(own - np.log(f)) < np.log(WIDE if max(f, 1.0 / f) > HUGE else 1.0 + NEAR_FACTOR)), None)
    if factor is None or abs(whole) < 0.5 * abs(own) or whole * own < 0.0:
        return None
    others = [_beside(logs[np.arange(len(logs)) != i], j, c) for j in range(len(logs) - 1)] if len(logs) > 2 else [0.0]
    return factor if max(map(abs, others)) < ORDERLY * abs(own) else None


def _apart(logs: np.ndarray, i: int) -> np.ndarray:
    """Logarithms (C,) of the ratios of session `i` to the median of the others."""
    return logs[i] - np.median(np.delete(logs, i, axis=0), axis=0)


def _beside(logs: np.ndarray, i: int, c: int) -> float:
    """Logarithm of a channel's ratio to the other sessions, less the median of the same for its session's other channels."""
    apart = _apart(logs, i)
    rest = np.delete(apart, c)
    return float(apart[c] - (np.median(rest) if rest.size else 0.0))


def _of_other_taxels(logs: np.ndarray, channels: list[str], i: int, c: int) -> list[float]:
    """Ratios of session `i`'s slopes to the other sessions', over their median, for all taxels but the one in column `c`."""
    apart = _apart(logs, i)
    usual = np.median(np.delete(apart, c)) if apart.size > 1 else 0.0
    return [float(np.exp(apart[k] - usual)) for k in range(len(channels)) if k != c and channels[k] != "force"]


def _of_channel(group: list, i: int, channel: str, factor: float, why: str, kind: str) -> _Fault:
    r = group[i]
    mended = "with its sign reversed" if factor < 0.0 else f"divided by {factor:.5g}"
    evidence = {"why": f"{why}. {r.name} is judged with {channel} {mended}", "kind": kind, "session": r.name}
    symptom = Symptom("data_error", sensor_of(channel, len(r.taxels)), (channel,), {"factor": quantity(factor, "1")}, evidence)
    return _Fault(symptom, i, r.scaled({channel: 1.0 / factor}))


def _reordered(group: list, names: list[str], slopes: np.ndarray) -> _Fault | None:
    """A session whose channels are those of the others in another order."""
    if len(names) < 2 or not np.all(np.any(slopes != 0.0, axis=1)):
        return None
    unit = slopes / np.linalg.norm(slopes, axis=1)[:, None]
    apart = [float(np.linalg.norm(row - _others(unit, i))) for i, row in enumerate(unit)]
    for i in np.argsort(apart)[::-1]:
        order = _order(unit[i], _others(unit, i))
        left = float(np.linalg.norm(unit[i, order] - _others(unit, i)))
        rest = _unlike(unit, i)
        if len(unit) > 2 and 2 * len(rest) <= len(unit):
            continue  # without a majority it is unknown which are in order
        steady = max(float(np.linalg.norm(row - np.median(rest, axis=0))) for row in rest)
        plainly = apart[i] > max(ODD, 3.0 * steady) and left < min(MENDS * apart[i], max(ALIKE, 2.0 * steady))
        exactly = len(group) > 2 and apart[i] > max(LITTLE, 10.0 * steady) and left < EXACTLY * apart[i]
        if plainly or exactly:
            return _of_order(group, names, int(i), order, apart[i], left)
    return None


def _unlike(unit: np.ndarray, i: int) -> np.ndarray:
    """The shares of the other sessions, without those that are nearer to session `i` than to the others' median."""
    rest = np.delete(unit, i, axis=0)
    odd = np.linalg.norm(rest - _others(unit, i), axis=1) > np.linalg.norm(rest - unit[i], axis=1)
    return rest[~odd]


def _others(unit: np.ndarray, i: int) -> np.ndarray:
    """The shares that the other sessions agree on: their normalised median."""
    middle = np.median(np.delete(unit, i, axis=0), axis=0)
    return middle / max(np.linalg.norm(middle), 1e-300)


def _order(own: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Which of a session's columns corresponds to each column of the others; columns that are not clearly elsewhere stay."""
    _, best = linear_sum_assignment((own[None, :] - others[:, None]) ** 2)
    gained = (own - others) ** 2 - (own[best] - others) ** 2
    order, seen = np.arange(own.size), set()
    for start in range(own.size):
        cycle, at = [], start
        while at not in seen:
            seen.add(at)
            cycle.append(at)
            at = int(best[at])
        if sum(gained[cycle]) > 0.1 * max(gained.sum(), 1e-300):
            order[cycle] = best[cycle]
    return order


def _of_order(group: list, names: list[str], i: int, order: np.ndarray, apart: float, left: float) -> _Fault:
    r = group[i]
    moved = [c for c in range(len(names)) if order[c] != c]
    said = ", ".join(f"what is called {names[order[c]]} is {names[c]}" for c in moved)
    why = (
        f"the shares of {r.name} are {100.0 * apart:.0f} % from those of the other sessions, and {100.0 * left:.1f} % with its columns in "
        f"another order{_either(group)}: {said}. {r.name} is judged with its columns so"
    )
    channels = tuple(names[c] for c in moved)
    evidence = {"why": why, "kind": SWAPPED, "session": r.name}
    right = r.with_channels({names[c]: r.channels[names[order[c]]] for c in moved})
    return _Fault(Symptom("data_error", sensor_of(channels[0], len(r.taxels)), channels, {}, evidence), i, right)


def _either(group: list) -> str:
    """A remark for two sessions: it is unknown which of them is right."""
    return f" (it may as well be the other one, {group[0].name} or {group[1].name}, that is wrong)" if len(group) == 2 else ""
