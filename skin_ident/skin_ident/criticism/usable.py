"""What a diagnosis requires of its recordings: the same channels, a load that moves, a depth whose zero is the surface, and enough samples.

If one of these is missing, the diagnosis would name causes that are not there: a plunger at rest makes taxels look dead, a depth in the
stage's own coordinates makes any skin seem to flow. Such recordings are refused with one sentence that says what to do.
"""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.pattern import listed
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.telemetry.more_than_applied import in_newtons
from skin_ident.criticism.telemetry.still import is_still
from skin_ident.criticism.telemetry.untared import starts_far_from_zero
from skin_ident.quality import FAR_TOO_MUCH, HARD, SOFT, far_too_little, impossible, most_felt, too_little
from skin_ident.recordings.assemble import counts_seconds
from skin_ident.recordings.repeated import same
from skin_models.model import Model
from skin_models.words import counted

IN_CONTACT = 0.05  # least share of the samples in contact
SHALLOW = 0.85  # the depth is refused if it never falls below this share of its maximum,
VANISHED = 0.1  # while the load there falls below this share: a skin would need a force that grows with the 14th power of the depth
DOUBTED, GONE = 0.3, 0.05  # the same two shares for a warning only
SHALLOWEST, DEEPEST = 5.0, 95.0  # percentiles that stand for minimum and maximum
ABOUT, RUNS, STAYS = 0.02, 0.1, 0.05  # shares of the greatest depth or force: about zero, range of what moves, range of what rests
FEWEST = 40  # samples in the common band, at least; the noise model predicts from the last eight
SELDOM = 5.0  # period of a topic over that of the recording, above which the error message mentions it
LONE_S = 10.0  # s, least length of a lone session, which is both fitted and held out by blocks


def belong_together(recordings: list, model: Model | None = None) -> None:
    """Raise `DiagnosisError` where sessions do not have the same channels, or lack what a diagnosis needs; `RecordingError` where their
    times may be in milliseconds."""
    kinds = {(r.kind, len(r.taxels), r.force is not None) for r in recordings}
    if len(kinds) > 1:
        said = "; ".join(f"{r.name}: {_what_it_has(r)}" for r in recordings)
        raise DiagnosisError(f"the recordings do not have the same channels ({said}): diagnose them apart, or leave out what some lack")
    if model is not None and len(model.shares) != len(recordings[0].taxels):
        said = f"the model has {counted(len(model.shares), 'taxel')}, the recordings have {len(recordings[0].taxels)}"
        raise DiagnosisError(f"{said}: name those of the model with --taxels, or give the model of this array")
    lasts = recordings[0].t[-1] - recordings[0].t[0] + 1.5 * recordings[0].dt  # N samples are N periods, and stamps jitter
    if len(recordings) == 1 and lasts < LONE_S:
        raise DiagnosisError(f"{recordings[0].name} is alone and lasts {lasts:.3g} s: give {LONE_S:g} s or more, or a second session")
    slowest = max(r.longest_period for r in recordings)
    for r in recordings:
        counts_seconds(r)
        _says_what_is_what(r)
        _has_both_sides(r)
        _is_long_enough(r, slowest)
        _touches(r)
        _has_its_zero_at_the_surface(r)
        _are_not_exchanged(r)


def _what_it_has(r) -> str:
    """The channels of a recording, in words."""
    taxels = counted(len(r.taxels), "taxel") if len(r.taxels) else ""
    return listed([*filter(None, ("depth" * (r.depth is not None), "force" * (r.force is not None), taxels))])


def are_other_data(recordings: list, hold_out: list) -> None:
    """Raise `DiagnosisError` where a held-out session was also fitted: it would be predicted by any model."""
    for kept in hold_out:
        twin = next((r.name for r in recordings if same(r, kept)), None)
        if twin is not None:
            said = f"{kept.name}, which is held out, holds the same samples as {twin}, which is fitted"
            raise DiagnosisError(f"{said}: hold out another session")


def in_sound_units(recordings: list, model: Model | None = None, twins: list | None = None) -> list:
    """The recordings, with a warning where all taxels feel next to nothing, or in no session clearly more. Raises `DiagnosisError` for
    sizes that only a wrong unit gives.

    Not for taxels in counts, which have no unit that could be wrong, nor if the given model, or a twin, is itself of such a size, since
    then the size is intended.
    """
    known = (model is not None and _is_of_no_skin(model)) or any(impossible(twin) for twin in twins or ())
    asked = [i for i in range(len(recordings[0].taxels)) if in_newtons(recordings, i)]
    for r in () if known else recordings:
        if said := impossible(r, asked):
            raise DiagnosisError(f"{r.name}: {said}")
    doubted = [r.warned(said) if (said := far_too_little(r, asked)) else r for r in recordings]
    faint = too_little(max(most_felt(r, asked) for r in recordings))  # in one session alone the plunger may be far from every taxel
    return warned_first(doubted, [faint]) if faint else doubted


def _is_of_no_skin(model: Model) -> bool:
    whole = model.dispersion.k1 + model.dispersion.k2
    return not SOFT <= whole <= HARD or model.dispersion.k1 * max(model.shares, default=0.0) > FAR_TOO_MUCH * whole


def enough_is_compared(train: list, held: list) -> None:
    """Raise `DiagnosisError` where plunger and skin part, or meet with a jump, nearly all the time, so that hardly any sample can be
    compared."""
    for sessions in filter(None, (train, held)):
        if sum(np.count_nonzero(s.weight, axis=1) for s in sessions).max() < FEWEST:
            raise DiagnosisError(
                f"hardly any sample of {', '.join(s.name for s in sessions[:3])} can be compared: the plunger is faster than the skin "
                "recovers, so that contact is lost and regained all the time; press more slowly, or deeper"
            )


def something_moves(recordings: list) -> None:
    """Raise `DiagnosisError` where depth or driving force is constant in all recordings, or where the load cell, or without one every
    taxel, does not respond to the depth."""
    where = f"in {recordings[0].name}" if len(recordings) == 1 else f"in any of the {len(recordings)} sessions"
    what = "force" if recordings[0].depth is None else "depth"
    if all(is_still(r.force if r.depth is None else r.depth) for r in recordings):
        raise DiagnosisError(
            f"the {what} never moves {where}, which does not excite the skin or its sensors: record presses that begin in the air and "
            "come back to it"
        )
    if what == "depth" and recordings[0].force is None and all(is_still(y) for r in recordings for y in r.taxels):
        raise DiagnosisError(f"no taxel follows the depth {where}, and there is no load cell: check wiring and channels, and record again")
    if what == "depth" and recordings[0].force is not None and all(is_still(r.force) for r in recordings):
        raise DiagnosisError(f"the force does not follow the depth {where}: repair the load cell, or leave its column out")


def _says_what_is_what(r) -> None:
    """Raise where, without a load cell, several columns in volts have names of converter channels: one of them may be the load cell."""
    volts = [n for n, unit in zip(r.taxel_names, r.taxel_units, strict=True) if unit == "V" and not n.startswith("taxel")]
    if r.force is None and len(volts) > 1:
        raise DiagnosisError(
            f"{r.name}: {', '.join(volts)} are in volts, and nothing says which is the load cell: declare in rig.yaml calibration: "
            f"{{{volts[0]}: {{channel: force, slope_n_per_v: …}}}}, and call taxels taxel_0_V, taxel_1_V, … or calibrate them, too"
        )


def named_apart(recordings: list) -> list:
    """The recordings with distinct names, so that findings can refer to them."""
    names = [r.name for r in recordings]
    while len(set(names)) < len(names):
        names = [name if names.count(name) == 1 else f"{name} ({i + 1})" for i, name in enumerate(names)]
    return [r if name == r.name else replace(r, name=name) for r, name in zip(recordings, names, strict=True)]


def warned_first(recordings: list, warnings: Iterable[str]) -> list:
    """The recordings, with warnings that concern all of them attached to the first."""
    first, *others = recordings
    return [first.warned(*warnings), *others]


def doubted(r):
    """The recording, with a warning if the load is already gone at a third of the greatest depth, or if a force that drives starts far from
    zero: the zero of what drives the test may be wrong."""
    if r.depth is None:
        return _tare_doubted(r)
    least, most = np.percentile(r.depth, [SHALLOWEST, DEEPEST])
    if least < DOUBTED * most or _left(r, least, most) > GONE:
        return r
    said = f"the depth never falls below {1e3 * least:.3g} mm, and there the load is already zero: the zero of depth may not be the surface"
    return r.warned(f"{said}, and then stiffness and curvature are wrong; zero the depth where the plunger touches the skin")


def _tare_doubted(r):
    """The recording of a test that a force drives, with a warning if that force starts far from zero."""
    if not starts_far_from_zero(r.force):
        return r
    least = np.percentile(r.force, SHALLOWEST)
    said = f"the force that drives the test starts from {least:.3g} N: if nothing presses there, the load cell was not tared"
    return r.warned(f"{said}, and causes may be named that are not there; subtract what it reads in the air")


def _has_both_sides(r) -> None:
    """Raise where either what presses (depth, force) or what responds is missing."""
    if r.force is None and r.depth is None:
        raise DiagnosisError(f"{r.name} has taxels alone: what pressed on them, depth or force, is needed too")
    if not len(r.taxels) and (r.force is None or r.depth is None):
        alone = "force" if r.depth is None else "depth"
        raise DiagnosisError(
            f"{r.name} has the {alone} alone: a second channel, {'depth' if r.depth is None else 'force'} or taxels, is needed"
        )


def _is_long_enough(r, slowest: float) -> None:
    """Raise where the samples are too few to estimate the noise in the common band; `slowest` is the period of the slowest topic, s."""
    band = Band(r.dt, slowest=slowest)
    kept = (len(r) - band.kernel.size) // band.every + 1
    if kept < FEWEST:
        least = r.dt * (band.kernel.size + FEWEST * band.every)
        lasts = f"{r.name} lasts {r.t[-1] - r.t[0]:.3g} s, too short to distinguish anything from noise: {least:.2g} s are needed at least"
        name, period = max(((name, own.period) for name, own in r.readings.items()), key=lambda each: each[1], default=("", 0.0))
        seldom = f", for {name} comes every {period:.2g} s only; leave it out, or record it faster" if period > SELDOM * r.dt else ""
        raise DiagnosisError(lasts + seldom)


def _touches(r) -> None:
    if r.depth is not None and float(np.mean(r.depth > 0.0)) < IN_CONTACT:
        raise DiagnosisError(f"{r.name} is hardly ever in contact (depth above zero): check the sign and the zero of its depth")


def _has_its_zero_at_the_surface(r) -> None:
    """Raise where the depth nearly always exceeds the skin's thickness, or hardly falls while the load vanishes."""
    if r.depth is None or is_still(r.depth):
        return
    least, most = np.percentile(r.depth, [SHALLOWEST, DEEPEST])
    advice = "it seems to count from the stage's own zero; subtract the depth at which the plunger touches the skin"
    thick = r.declared.skin_thickness_mm
    if thick and least > 1e-3 * thick:
        raise DiagnosisError(
            f"the depth of {r.name} is above {1e3 * least:.4g} mm nearly all the time, in a skin of {thick:g} mm: {advice}"
        )
    if least > SHALLOW * most and _left(r, least, most) < VANISHED:
        said = f"the depth of {r.name} stays between {1e3 * least:.4g} and {1e3 * most:.4g} mm while the load comes and goes"
        raise DiagnosisError(f"{said}: {advice}")


def _are_not_exchanged(r) -> None:
    """Raise where the depth rests at zero while the force runs below zero: in the air the plunger moves and the load cell reads nothing, so
    the columns may be exchanged."""
    if r.depth is None or r.force is None:
        return
    deep, strong = (float(np.percentile(y, DEEPEST)) for y in (r.depth, r.force))
    at_surface, untouched = np.abs(r.depth) < ABOUT * deep, np.abs(r.force) < ABOUT * strong
    if min(np.count_nonzero(at_surface), np.count_nonzero(untouched)) < FEWEST:
        return
    (low, high), (up, down) = (np.percentile(y, [SHALLOWEST, DEEPEST]) for y in (r.force[at_surface], r.depth[untouched]))
    if high - low > RUNS * strong and np.median(r.force[at_surface]) < 0.0 and down - up < STAYS * deep:
        raise DiagnosisError(
            f"the force of {r.name} runs down to {low:.3g} N where the depth is about zero, and the depth rests where the force is about "
            "zero: for a plunger in the air it is the other way round; are the columns of depth and force exchanged?"
        )


def _left(r, least: float, most: float) -> float:
    """The load at the least depth over that at the greatest."""
    y = r.force if r.force is not None else np.sum(r.taxels, axis=0)
    light, heavy = (abs(float(np.median(y[at]))) for at in (r.depth <= least, r.depth >= most))
    return light / heavy if heavy > 0.0 else 1.0
