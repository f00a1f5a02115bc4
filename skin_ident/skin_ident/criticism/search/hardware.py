"""What held-out data support and is still no finding, because good hardware does as much by itself. It is reported, with what would
tell.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from skin_ident.criticism.baseline.residual import stiffness
from skin_ident.criticism.courses.carriers import DEPTH
from skin_ident.criticism.courses.left_by_tare import Tare, drive_rests, tare_of_drive
from skin_ident.criticism.courses.run import AT_REST, Run, least_depth
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.gate import Gain
from skin_ident.criticism.gates.resolution import converter_step, of_the_converter, of_the_drive, resolved, unreadable
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.search.named import NotNamed
from skin_ident.criticism.vocabulary import DEAD_ZONE, HYSTERESIS, Key
from skin_models.catalogue import effects as all_effects
from skin_models.effect import Effect
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, PROMPT, parameters_of

FINER = "an encoder, and converters, with finer steps and less noise"
CROSSES = 3.0  # standard deviations of a resting force that count as the reach of its noise
SOONER = "amplifiers of known, greater bandwidth, and converters that are triggered together"
LATE = "filters of good amplifiers, and converters that take turns, are late by up to {}"
TRUER = "a stage of known, higher accuracy, and touches that begin and end in free air"


def converter_does(claim: Claim) -> NotNamed | None:
    """Why a cause that gains is no finding, where the converter may do as much by itself; else None."""
    if not (claim.gain.passed and of_the_converter(claim)):
        return None
    step = converter_step(claim.train, claim.channel)
    why = f"it would {_worth(claim.gain)}, but a converter with steps of {step:.2g} N may cause as much by itself"
    return _usual(why, f"a {claim.channel} read in finer steps, or a larger force")


def negligible(e: Effect) -> bool:
    """Whether every amplitude of an effect is within what good hardware has anyway."""
    sizes = [p for p in parameters_of(e) if p.role == AMPLITUDE]
    return bool(sizes) and all(abs(p.value) <= p.negligible for p in sizes)


def forms_of_hardware(e: Effect) -> Iterator[Effect]:
    """An effect's cause in its other forms of which good hardware has a little, each as large as that."""
    for cls in all_effects():
        if cls.cause != e.cause or e.where not in cls.places or cls is type(e):
            continue
        usual = {p.name: p.negligible for p in parameters_of(cls.typical(e.where)) if p.role == AMPLITUDE}
        if usual and all(usual.values()):
            yield cls.typical(e.where, **usual)


def hardware_is_off(effects: list[Effect], gain: Gain) -> NotNamed | None:
    """Why effects that gain are no finding, where they are no larger than good hardware has them anyway; else None."""
    small = [p for e in effects for p in parameters_of(e) if p.role == AMPLITUDE and 0.0 < abs(p.value) <= p.negligible]
    if not (small and gain.passed):
        return None
    largest = max(small, key=lambda p: (p.unit in IN_WORDS, abs(p.value) / p.negligible))
    found, least = (IN_WORDS.get(largest.unit, "{:.2g} ppm".format)(x) for x in (abs(largest.value), largest.negligible))
    would = f"it would be {found} and {_worth(gain)}"
    if largest.unit == "m":
        return _usual(f"{would}, but even a good stage is accurate to no better than {least}", TRUER)
    return _usual(f"{would}, but {LATE.format(least)}", SOONER)


def encoder_does(claim: Claim, noise: Whitener, encoder_step: float) -> NotNamed | None:
    """Why a cause that gains is no finding, where noise of the driving signal does as much, where the encoder could not tell the size of
    the cause, or where steps leave as much open; else None."""
    if of_the_drive(claim):
        worth = f"it would {_worth(claim.gain)}, but mostly while the driving force rests, or only a small part of the error"
        return _usual(f"{worth}: the noise of that force may cause as much", "a depth beside the force, or a load cell with less noise")
    return too_short(claim.key, claim.after, encoder_step) or _drive_crosses(claim) or steps_do(claim, noise, encoder_step)


def _drive_crosses(claim: Claim) -> NotNamed | None:
    """Why a threshold that gains is no finding, where noise or the zero of the driving force reaches across it; else None."""
    if not claim.driven or claim.cause != DEAD_ZONE:
        return None
    model = claim.after
    felt = model.dispersion.k1 if claim.key[1] == "skin" else stiffness(model, claim.channel)
    applied = max(e.threshold for e in model.having(claim.key)) * stiffness(model, "force") / max(felt, 1e-9)
    rest = np.concatenate([s.drive[drive_rests(s)] for s in claim.train])
    reach = max(tare_of_drive(claim.train).leaves, CROSSES * float(np.sqrt(np.mean(rest**2))) if rest.size else 0.0)
    why = f"it would take away {applied:.2g} N of the applied force, but noise and zero error of this force are up to {reach:.2g} N"
    return _usual(why, "a load cell with finer steps and less noise, or a depth beside the force") if applied <= reach else None


def too_short(key: Key, after: Model, encoder_step: float) -> NotNamed | None:
    """Why a cause that is a length, or a loop as narrow as one, is no finding where the encoder does not read so finely; else None."""
    length = unreadable(key, after, encoder_step)
    what = f"{'a loop that is half as wide as ' if key == HYSTERESIS else ''}{_micrometres(length)}"
    why = f"it would be {what}, but the encoder reads no finer than {_micrometres(encoder_step)}"
    return _usual(why, FINER) if length else None


def steps_do(claim: Claim, noise: Whitener | None, encoder_step: float) -> NotNamed | None:
    """Why a cause that gains is no finding, where steps of encoder and converters may account for as much; else None."""
    if resolved(claim, noise, encoder_step):
        return None
    worth = f"it would {_worth(claim.gain)}"
    if not encoder_step:
        return _usual(f"{worth}, but the steps of the converters may cause as much", "converters with finer steps")
    step = _micrometres(encoder_step)
    return _usual(f"{worth}, but the steps of the encoder (no finer than {step}) and of the converters may cause as much", FINER)


def stage_does(run: Run, encoder_step: float) -> NotNamed:
    """Why a course is no finding that is smaller than what a good stage or clock does, or than what an encoder reads."""
    if run.course.carrier == DEPTH:
        return _zero_of_depth(f"within single sessions the zero of depth would step by {_micrometres(run.largest)}", encoder_step)
    found, least = map(_milliseconds, (run.largest, run.least(encoder_step)))
    return _usual(f"within single sessions the delay would step by {found}, but good hardware steps by up to {least} by itself")


def zeros_do(largest: float, encoder_step: float) -> NotNamed:
    """Why zeros of depth of sessions' own, the `largest` of them in m, are no finding: stage or encoder do as much."""
    return _zero_of_depth(f"the zeros of depth of single sessions are off by up to {_micrometres(largest)}", encoder_step)


def _zero_of_depth(why: str, encoder_step: float) -> NotNamed:
    """Why a zero of depth is no finding, as `why` says how large it is."""
    least = _micrometres(least_depth(encoder_step))
    if encoder_step >= AT_REST:
        return _usual(f"{why}, but the encoder reads no finer than {least}", FINER, own_zero=True)
    return _usual(f"{why}, but good hardware steps by up to {least} by itself", own_zero=True)


def tare_does(largest: float, tare: Tare) -> NotNamed:
    """Why zeros of sessions' own, the `largest` of them in N, are no finding: a `tare` sets them no better."""
    off = f"the zeros of single sessions are off by up to {largest:.2g} N"
    needs = "a converter with finer steps, and tares of many seconds in free air"
    return _usual(f"{off}, but {tare.said} may leave as much", needs, own_zero=True)


def delay_does(late: float) -> NotNamed:
    """Why a delay of the depth, s, is no finding."""
    return _usual(f"the depth and the forces are apart by {_milliseconds(late)}, but {LATE.format(_milliseconds(PROMPT))}", SOONER)


def specimens_do(largest: Mapping[str, float], lone: bool = False) -> NotNamed:
    """Why skin parameters of sessions' own are no finding; `largest` is the largest relative departure of each by name. `lone`: there is
    one session, and its parts that were fitted and held out are what differ."""
    off = ", ".join(f"{name} by up to {100.0 * share:.2g} %" for name, share in largest.items())
    if lone:
        why = f"the skin differs between the parts of this session that were fitted and held out ({off})"
        needs = "a second session of the same specimen, in the same place and at the same temperature"
        return _usual(f"{why}, as it does where its temperature changes, or where a model is not exact", needs)
    needs = "sessions of one specimen in one place and at one temperature, or separate parameters for each session"
    return _usual(f"the skin differs between sessions ({off}), as it does between specimens, temperatures and places", needs)


def skin_does(run: Run) -> NotNamed:
    """Why a gain, or a zero of depth, of sessions' own is no finding: a skin that is another in each of them explains as much or more."""
    depth = run.course.carrier == DEPTH
    what, off = ("zeros of depth", _micrometres(run.largest)) if depth else ("gains", f"{100.0 * run.largest:.2g} %")
    why = f"the {what} of single sessions would be off by up to {off}, but a skin that differs from session to session may look the same"
    return _usual(f"{why}: these sessions do not show which of the two it is", "many sessions of one specimen in one place, with taxels")


def no_other_does(key: Key, why: NotNamed) -> NotNamed:
    """Why what cannot be told from the cause and place `key` is no finding, where that one is none because of hardware."""
    cause, where = key
    return replace(why, because=f"it cannot be told from {cause} in the {where}: {why.because}")


def _worth(gain: Gain) -> str:
    return f"explain {np.sqrt(gain.squares):.2g} N rms of {gain.channel}"


def _micrometres(length: float) -> str:
    return f"{1e6 * length:.3g} µm"


def _milliseconds(time: float) -> str:
    return f"{1e3 * time:.3g} ms"


def _usual(why: str, needs: str = "", own_zero: bool = False) -> NotNamed:
    """Something of any size that is no finding because hardware does as much."""
    return NotNamed(np.inf, why, needs, hardware=True, own_zero=own_zero)


IN_WORDS = {"m": _micrometres, "s": _milliseconds}  # by unit
