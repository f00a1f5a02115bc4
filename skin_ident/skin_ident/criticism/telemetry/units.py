"""Units and names of columns: a channel in other units, all the time, from some time on or in one session; two columns swapped; a sign.

The converter's grid proves it where the steps are declared (see `grid`); the slope against depth shows it where they are not.
"""

from collections.abc import Sequence

import numpy as np

from skin_ident.criticism.pattern import listed
from skin_ident.criticism.telemetry.grid import factor_of, sits_on
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of
from skin_ident.criticism.vocabulary import SWAPPED, UNIT_CHANGE, UNIT_FACTOR

# A pound-force and a kilogram-force in N, a technical atmosphere in MPa, each either way; thousands, and a point that is out of place.
FACTORS = (4.44822, 1 / 4.44822, 9.80665, 1 / 9.80665, 0.0980665, 1 / 0.0980665, 1000.0, 1e-3, 10.0, 0.1)
OF_TEN = 0.1  # of the declared step: levels of a channel whose amplifier averages ten readings of its converter, as many do
NEAR_FACTOR = 0.06  # relative deviation of a ratio of slopes from such a factor
PIECES = 12  # pieces of a session, each tested for its grid
FOLLOWS = 0.5  # correlation with the load, without which a slope means nothing
WITHIN, ENOUGH = 0.3, 0.1  # share of the greatest depth beyond which contact is sure; share of the samples that must be there
AGAINST = -0.6  # correlation with the load below which a channel is upside down
# Range of a load as a share of its greatest magnitude. Up to the first, the load is held: a stage that gives way while the skin relaxes
# deepens as the force falls, and a slope says nothing of the skin. From the second on, a relaxation cannot pass for a wrong sign.
HELD, FAIR = 0.05, 0.2
TO_AND_FRO = 4  # crossings of its middle by a load about a preload
SAME = 0.8  # least ratio of a taxel's slopes in two sessions at one place


def find_unit_faults(recordings: list) -> list[Symptom]:
    """All such faults; swapped channels are not tested for their units."""
    swapped = _swapped(recordings)
    names = {c for s in swapped for c in s.channels}
    rest = [c for c in recordings[0].channels if c not in names]
    found = [s for c in rest for s in (by_grid(recordings, c) or _by_slope(recordings, c))]
    return [*swapped, *found, *(s for c in rest for s in _upside_down(recordings, c))]


def declared_step(recording, channel: str) -> float | None:
    """The converter step, N, that rig.yaml declares for a channel; None for a taxel that is left in volts."""
    d = recording.declared
    if channel == "force":
        return d.force_step_n
    i = int(channel.split("_")[1])
    return d.of_taxel("taxel_step_n", i) if recording.taxel_units[i] == "N" else None


def _swapped(recordings: list) -> list[Symptom]:
    """Two channels that each sit on the other's grid and not on their own."""
    names = list(recordings[0].channels)
    steps = {c: declared_step(recordings[0], c) for c in names}
    rows = {c: np.concatenate([r.channels[c] for r in recordings]) for c in names}
    lost = [c for c in names if steps[c] and not sits_on(rows[c], steps[c])]
    for i, a in enumerate(lost):
        for b in lost[i + 1 :]:
            if sits_on(rows[a], steps[b]) and sits_on(rows[b], steps[a]):
                levels = f"the levels of {a} are {steps[b]:.4g} N apart, as those of {b} should be, and the other way round"
                why = f"{levels}: the columns are swapped"
                return [Symptom("data_error", _place(a, recordings), (a, b), {}, {"why": why, "kind": SWAPPED})]
    return []


def by_grid(recordings: list, channel: str) -> list[Symptom]:
    """A channel in other units, as its declared step shows."""
    step = declared_step(recordings[0], channel)
    if not step:
        return []
    pieces = [(r, k, factor_of(y, step, FACTORS)) for r in recordings for k, y in enumerate(np.array_split(r.channels[channel], PIECES))]
    wrong = [(r, k, f) for r, k, f in pieces if f not in (None, 1.0)]
    if len(wrong) < 2 or len({f for _, _, f in wrong}) > 1:
        return []
    (r, k, factor), known = wrong[0], [p for p in pieces if p[2] is not None]
    if len(wrong) == len(known):
        if factor == OF_TEN:
            return []
        why = (
            f"the levels of {channel} are {factor:.5g} times as far apart as declared, in all {len(recordings)} sessions: a factor of units"
        )
        return [_unit(recordings, channel, factor, why, UNIT_FACTOR)]
    whole = [r.name for r in recordings if all(f == factor for q, _, f in known if q is r) and any(q is r for q, _, _ in known)]
    if {q.name for q, _, _ in wrong} <= set(whole):
        apart = f"the levels of {channel} are {factor:.5g} times as far apart as in the other sessions"
        why = f"throughout {listed(whole)} {apart}: its unit is another there"
    else:
        since = f"from about {r.t[k * len(r) // PIECES]:.1f} s on in {r.name}"
        why, whole = f"{since} the levels of {channel} are {factor:.5g} times as far apart as before: its unit changed", []
    return [_unit(recordings, channel, factor, why, UNIT_CHANGE, whole)]


def _by_slope(recordings: list, channel: str) -> list[Symptom]:
    """Sessions whose slope against the load differs from the others' by a factor of units, one symptom for each factor. Not tested for
    taxels of sessions that press at different places, declared or not, where the slope depends on the place."""
    if recordings[0].spread is not None and channel != "force":
        return []
    recordings = [r for r in recordings if load_of(r, channel) is not None]
    if len(recordings) < 2:
        return []
    ratios = _ratios(recordings, channel)
    near = [near_factor(ratio) for ratio in ratios]  # some are near each other
    rest = [] if channel == "force" else [_ratios(recordings, c) for c in recordings[0].channels if c not in ("force", channel)]
    near = [None if presses_elsewhere([own[i] for own in rest]) else f for i, f in enumerate(near)]
    found = []
    for factor in dict.fromkeys(f for f in near if f):
        odd = [i for i, f in enumerate(near) if f == factor]
        names = [recordings[i].name for i in odd]
        why = f"{channel} of {listed(names)} is {np.median(ratios[odd]):.4g} times what the other sessions say: a factor of units"
        found.append(_unit(recordings, channel, factor, why, UNIT_FACTOR, names))
    return found


def _ratios(recordings: list, channel: str) -> np.ndarray:
    """A channel's slope in every session (S,), over their median; NaN in all if it does not follow the load in one."""
    slopes = np.array([_slope(r, channel) for r in recordings])
    return slopes / np.median(slopes) if np.all(np.abs(slopes) >= 1e-9) else np.full(len(slopes), np.nan)


def near_factor(ratio: float) -> float | None:
    """The factor of units that a ratio of slopes is near to."""
    return next((f for f in FACTORS if abs(ratio / f - 1.0) < NEAR_FACTOR), None)


def presses_elsewhere(ratios: Sequence[float]) -> bool:
    """Whether a session presses at another place than the others, though nobody declared it: from the `ratios` of its slopes to theirs for
    the taxels beside the one that is tested. Then two of them or more, or the only one, are far from 1 and are no factors of units either.
    One alone among several has a fault of its own."""
    far = [(r < SAME or r > 1.0 / SAME) and not near_factor(r) for r in ratios]
    return sum(far) >= min(2, max(len(far), 1))


def _unit(recordings: list, channel: str, factor: float, why: str, kind: str, sessions: Sequence[str] = ()) -> Symptom:
    """The symptom; `sessions` are those that have the fault throughout, where others do not."""
    evidence = {"why": why, "kind": kind, **({"session": sessions[0]} if len(sessions) == 1 else {})}
    return Symptom("data_error", _place(channel, recordings), (channel,), {"factor": quantity(factor, "1")}, evidence)


def _upside_down(recordings: list, channel: str) -> list[Symptom]:
    """A channel that falls while the load rises."""
    told = told_signs(recordings, channel)
    wrong = np.flatnonzero(told < AGAINST)
    if not wrong.size:
        return []
    falls = f"{channel} falls while the load rises (correlation {told[wrong[0]]:.2f} in {recordings[wrong[0]].name})"
    why = f"{falls}: its sign is wrong in {wrong.size} of {np.count_nonzero(np.isfinite(told))} sessions that tell it"
    return [Symptom("data_error", _place(channel, recordings), (channel,), {"factor": quantity(-1.0, "1")}, {"why": why, "kind": "sign"})]


def told_signs(recordings: list, channel: str) -> np.ndarray:
    """A channel's correlation with the load in every session (S,), which tells its sign; NaN where the load does not move enough to tell
    it, 0 where the channel holds one reading."""
    return np.array([_sign(r, channel) if _moves_enough(load_of(r, channel)) else np.nan for r in recordings])


def _sign(recording, channel: str) -> float:
    """Correlation with the load, or that in the second half alone if it is greater, as far as the channel is loaded there: a wrong sign
    stays to the end, but what the skin still relaxes from a touch before the recording dies away."""
    x, y, half = load_of(recording, channel), recording.channels[channel], len(recording) // 2
    x = x if recording.depth is None else np.maximum(x, 0.0)  # in the air the plunger moves, too, and tells nothing
    told = np.ptp(x[half:]) > HELD * np.max(np.abs(x)) and np.ptp(y[half:]) > 0.0
    return max(follows(recording, channel), float(np.corrcoef(x[half:], y[half:])[0, 1]) if told else -1.0)


def _moves_enough(load: np.ndarray | None) -> bool:
    """Whether a load ranges over a fair share of its greatest magnitude, or goes to and fro, as no stage does that gives way while the skin
    relaxes. Single samples do not count: they may be spikes of an encoder."""
    if load is None:
        return False
    low, high = np.percentile(load, (1.0, 99.0))
    off = load - 0.5 * (low + high)
    sides = np.sign(off[np.abs(off) > 0.25 * (high - low)])
    fair = high - low >= FAIR * np.percentile(np.abs(load), 99.0)
    return bool(fair or np.count_nonzero(np.diff(sides)) >= TO_AND_FRO)


def follows(recording, channel: str) -> float:
    """Correlation with the load."""
    x, y = load_of(recording, channel), recording.channels[channel]
    return 0.0 if np.ptp(y) == 0.0 else float(np.corrcoef(x, y)[0, 1])


def load_of(recording, channel: str) -> np.ndarray | None:
    """The load that a channel responds to: the depth (N,) m, or the force that drives a test without depth, N; None where it is held."""
    load = recording.depth if recording.depth is not None else recording.force if channel != "force" else None
    return load if load is not None and np.ptp(load) > HELD * np.max(np.abs(load)) else None


def pressed(recording) -> np.ndarray:
    """Mask (N,) of the samples well within contact, where an attached mass loads the cell in a way that it does not in air. All samples,
    where force drives the test or contact is hardly made."""
    if recording.depth is None:
        return np.ones(len(recording), bool)
    deep = recording.depth > WITHIN * np.percentile(recording.depth, 99.0)
    return deep if np.mean(deep) > ENOUGH else np.ones(len(recording), bool)


def _slope(recording, channel: str) -> float:
    if load_of(recording, channel) is None or abs(follows(recording, channel)) < FOLLOWS:
        return float("nan")
    x, y = load_of(recording, channel), recording.channels[channel]
    x = x - x.mean()
    return float(x @ (y - y.mean()) / (x @ x))


def _place(channel: str, recordings: list) -> str:
    return sensor_of(channel, len(recordings[0].taxels))
