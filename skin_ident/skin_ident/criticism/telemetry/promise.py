"""Whether a taxel ought to feel the load: by its declared place, or because it lies between two taxels that do.

Any spread decreases from the contact in all directions, so a taxel on the straight line between two others feels at least what the lesser
of them does. Without a declared layout only the second of three taxels is taken to lie between others, as numbered in a row. With more
taxels, or three chosen out of more, the numbers may go row by row over an area.

A sensor outside the contact still has its noise. One with next to none of the declared noise, where others have about that, is open.
"""

import numpy as np

from skin_ident.estimators.scale import white_noise

WIDTH = 0.0045  # m, narrower than any Gaussian spread of thesis Table 4-8
AWAY = 0.002  # m, error of the plunger's position
CLEAR = 3.0  # noise widths that the promised signal must have
SHARE = 0.4  # least share of the applied force that the thesis's skins lead through a taxel under the plunger
FELT = 0.1  # share of the load that the lesser of two neighbours must feel
NOTHING = 0.005  # share of what the lesser neighbour feels, below which a reading is silence
QUIET, USUAL = 0.3, 0.5  # share of the declared noise that an open taxel reads at most, and that others read at least
MIDDLE, BESIDE = (0.2, 0.8), 0.1  # to lie between two taxels: share of the way from one to the other; distance off the line, relative to it


def promised(recordings: list, i: int, n: int) -> str:
    """A clause that says what promises taxel `i` of `n` a reading well above its noise; empty where it may simply lie outside the
    contact."""
    if n == 1:
        return "though there is a load"
    places = len(recordings[0].declared.taxel_positions_mm)
    if i < places and _by_place(recordings[0], i):
        return "though its place says that it should"
    pair = next((p for r in recordings for p in _pairs(r, i, n) if _between(r, i, *p)), None)
    how = "" if places else ", as they are numbered,"
    if pair:
        return f"though taxel_{pair[0]} and taxel_{pair[1]} on both sides of it{how} say that it should"
    return _without_noise(recordings, i)


def _without_noise(recordings: list, i: int) -> str:
    """A clause if a taxel has next to nothing of its declared noise while every other taxel has noise as declared; else empty."""
    declared = recordings[0].declared
    levels = [declared.of_taxel("taxel_noise_n", k) for k in range(len(recordings[0].taxels))]
    if not all(levels) or set(recordings[0].taxel_units) != {"N"}:
        return ""
    own = max(float(np.std(r.taxels[i])) for r in recordings)
    others = [max(white_noise(r.taxels[k]) for r in recordings) / level for k, level in enumerate(levels) if k != i]
    if own > QUIET * levels[i] or min(others) < USUAL:
        return ""
    return f"nor has it the noise of a taxel, which rig.yaml declares to be {levels[i]:.3g} N (it varies by {own:.2g} N)"


def least_step(recordings: list, i: int) -> float:
    """The converter step of taxel `i`, N: of a row that never changes, the declared one, or else the finest of the other taxels; 0 where
    nothing tells."""
    own = max((r.step(f"taxel_{i}") or 0.0 for r in recordings), default=0.0) or recordings[0].declared.of_taxel("taxel_step_n", i)
    others = [r.step(f"taxel_{k}") for r in recordings for k in range(len(r.taxels)) if k != i]
    return own or min(filter(None, others), default=0.0)


def _unclear(r, i: int) -> float:
    """What a reading must exceed to be more than noise or less than a converter's step, N."""
    return CLEAR * max(float(np.std(r.taxels[i])), least_step([r], i) if np.ptp(r.taxels[i]) == 0.0 else 0.0)


def _by_place(r, i: int) -> bool:
    load = r.force if r.force is not None else np.sum(r.taxels, axis=0)
    distance = 1e-3 * float(np.hypot(*np.subtract(r.declared.taxel_positions_mm[i], r.declared.contact_of(r.name)))) + AWAY
    return SHARE * np.exp(-((distance / WIDTH) ** 2)) * float(np.std(load)) > _unclear(r, i)


def _pairs(r, i: int, n: int) -> list[tuple[int, int]]:
    """Pairs of taxels between which taxel `i` lies."""
    places = np.array(r.declared.taxel_positions_mm, float)
    if len(places) < n:
        return [(0, 2)] if n == 3 and i == 1 and not len(places) and not r.some else []
    pairs = []
    for a in (a for a in range(n) if a != i):
        along, out = places[a + 1 :] - places[a], places[i] - places[a]
        length = np.maximum(np.hypot(*along.T), 1e-9)
        part = along @ out / length**2
        off = np.abs(along[:, 0] * out[1] - along[:, 1] * out[0]) / length**2
        pairs += [(a, a + 1 + int(k)) for k in np.flatnonzero((part > MIDDLE[0]) & (part < MIDDLE[1]) & (off < BESIDE)) if a + 1 + k != i]
    return pairs


def _between(r, i: int, a: int, b: int) -> bool:
    """Whether both neighbours feel the load, and taxel `i` reads nothing in comparison."""
    load = r.force if r.force is not None else np.sum(r.taxels, axis=0) - r.taxels[i]
    load = load - load.mean()
    energy = float(load @ load)
    if energy <= 0.0:
        return False
    own, *felt = (float(load @ r.taxels[k]) / energy for k in (i, a, b))
    least = min(felt)
    clear = least * np.sqrt(energy / load.size) > _unclear(r, i)
    return least > FELT and clear and abs(own) < NOTHING * least
