"""How much better the extended model is: the large number on the first screen, and the sentences that support it."""

from dataclasses import dataclass

from skin_ident.criticism.above import AT_FLOOR
from skin_ident.criticism.vocabulary import spoken
from skin_ident.report.counsel import TESTED
from skin_ident.report.numbers import amount, fall_span, percent
from skin_ident.report.view import IN_TURN, PARTLY, UNEXPLAINED, ChannelError, View
from skin_ident.report.words import capital, signal

ALIKE = 1.02  # times the noise floor: an error up to this is shown as equal to the noise
QUIETER = 0.995  # times the noise floor: an error below this is printed as smaller than the noise
ANY_SCALE = "at any scale"  # ends the `held_out` text of findings that were judged with a scale fitted to each session
LEAST = 0.05  # smallest relative fall of a channel's error that is reported


@dataclass(frozen=True)
class Figure:
    """A number, what it is, and the sentences behind it."""

    number: str
    caption: str
    sentences: tuple[str, ...]


def better(v: View) -> Figure:
    """The gain to show: in the sensor in which the first judged finding lies, else in the channel that it names, else in the channel that
    gained most."""
    told = [e for e in v.errors if None not in e.pair and e.pair[0]]
    if not told:
        return Figure("Not measured", "", () if v.errors else ("No simulation was compared with these data.",))
    alive = [e for e in told if e.channel not in v.silent]
    named = any(f.carried for f in v.findings)  # else what falls is due to zeros that each session was allowed, and no gain
    if named and not v.judged and any(fall(e) > LEAST and e.interval and e.interval[0] > 0.0 for e in alive):
        return _gain(max(alive, key=fall), v)
    if not v.judged:
        return _no_gain(v, told)
    told = [e for e in told if e.channel not in v.silent] or told
    *own, gained = ([e for e in told if e.channel == c] for c in v.judged[0].shown_in)
    own = [e for each in own for e in each if fall(e) > LEAST]
    return _gain(next(iter([*own, *gained]), None) or max(told, key=fall), v)


def fall(e: ChannelError) -> float:
    """Relative fall of a channel's error, on held-out data where it is known."""
    before, after = e.pair
    return 1.0 - after / before if before and after is not None else 0.0


def _no_gain(v: View, told: list[ChannelError]) -> Figure:
    """The figure where nothing was added to the model: its error compared with the noise."""
    at_noise = all(e.floor is not None and e.pair[1] < AT_FLOOR * e.floor for e in told)
    said = [f"Typical error of the {signal(e.channel)}: {error(e.pair[1], e, v)}{_when_fitted(e, v)}." + _floor(e, v) for e in told[:2]]
    said += filter(None, [allowed(v)])
    unmeasured = dict.fromkeys(f.unmeasured for f in v.findings if f.unmeasured)
    if v.findings and all(f.unmeasured for f in v.findings):
        return Figure("Not measured", f"by this comparison, for {' and '.join(unmeasured)}", tuple(said))
    if v.findings:
        return Figure("No change", "the named faults are in the record, not in the model", tuple(said))
    if v.verdict == UNEXPLAINED:
        return Figure("No gain", "no cause could be added to the model", tuple(said))
    return Figure("Nothing to gain" if at_noise else "No gain", "" if at_noise else "no cause could be added to the model", tuple(said))


def error(x: float | None, e: ChannelError, v: View) -> str:
    """An error of a channel, in the unit that all errors share."""
    return amount(x, e.unit, like=v.loudest or [*e.pair, e.floor])


def allowed(v: View) -> str:
    """Where nothing named is in the model: which freedom the simulation was allowed that is no fault (such as zeros of each session), and
    what its error would be without it. No gain is claimed for it. Empty where it hardly changes the error."""
    changed = [e for e in v.errors if None not in e.pair and fall(e) > LEAST and e.channel not in v.silent]
    if any(f.carried for f in v.findings) or not changed:
        return ""
    own = f"each session has its own {' and '.join(v.own_zeros)}, of a size that good hardware and a tare leave"
    had = own if v.own_zeros else "what is fitted is not a fault, see the warnings"
    without = " and ".join(f"{error(e.pair[0], e, v)} in the {signal(e.channel)}" for e in changed)
    return f"Here {had}; without this the error would be {without}."


def _when_fitted(e: ChannelError, v: View) -> str:
    """A clause with the error on the sessions that were fitted, where it is clearly larger than on the held-out ones."""
    fitted = e.train[1]
    if fitted is None or e.held_out[1] is None or fitted < AT_FLOOR * e.held_out[1]:
        return ""
    return f", and {error(fitted, e, v)} on the data it was fitted to"


def _floor(e: ChannelError, v: View) -> str:
    if e.floor is not None and e.pair[1] is not None and e.pair[1] <= ALIKE * e.floor:
        return " That is no more than noise."
    return "" if e.floor is None else f" Noise alone leaves {error(e.floor, e, v)}."


def quieter(v: View) -> str:
    """A sentence for the errors by channel, where one of them is below the noise floor: the floor may be of another session."""
    if not any(e.floor and e.pair[1] is not None and e.pair[1] < QUIETER * e.floor for e in v.errors):
        return ""
    return "Noise alone was measured in other data than this error, which may be quieter: an error can be smaller than it."


def _gain(e: ChannelError, v: View) -> Figure:
    before, after = _tested_pair(e, v)
    share, scaled = 1.0 - after / before, at_any_scale(e, v)
    together = "" if len(v.findings) == 1 else " with everything named here together"
    scale = ", with a scale factor fitted to each session" if scaled else ""
    caption = f"{'less' if share >= 0 else 'more'} error in the {signal(e.channel)}{together}, on {TESTED[v.tested]}{scale}"
    said = [
        f"Typical error: {error(before, e, v)} before, {error(after, e, v)} after.",
        _interval(v, e),
        _as_it_is(e, v) if scaled else "",
        _where_it_lies(e, v),
        _bound(e, after, v),
    ]
    return Figure(percent(abs(share)), caption, tuple(s for s in said if s))


def _tested_pair(e: ChannelError, v: View) -> tuple[float, float]:
    """Error before and after on data that test the gain. Where sessions were held out in turn, or each had its own scale, only the findings
    hold these errors."""
    steps = [f.gain for f in v.judged if f.gain.channel == e.channel and f.gain.before and f.gain.after is not None]
    by_finding = (v.tested == IN_TURN and not v.in_turn) or at_any_scale(e, v)
    return (steps[0].before, steps[-1].after) if by_finding and steps else e.pair


def at_any_scale(e: ChannelError, v: View) -> bool:
    """Whether the gain in a channel only shows when each session has a scale of its own: the findings were judged so, and the fall of the
    plain error is not significant."""
    own = [f.gain for f in v.judged if f.gain.channel == e.channel and f.gain.before and f.gain.after is not None]
    plainly = e.interval is not None and e.interval[0] > 0.0
    return bool(own) and not plainly and all(g.held_out.endswith(ANY_SCALE) for g in own)


def _as_it_is(e: ChannelError, v: View) -> str:
    before, after = (error(x, e, v) for x in e.pair)
    return (
        f"Without these factors the error is {before} before and {after} after: these sessions differ from the fitted ones by a factor, "
        "which is not part of what is named; see what each session says by itself."
    )


def _interval(v: View, e: ChannelError) -> str:
    if e.interval and not at_any_scale(e, v):
        return _fall_said("The fall is", "This fall", *e.interval, e.pair[0], e.unit, v)
    gains = [f.gain for f in v.judged if f.gain.channel == e.channel and f.gain.low is not None and f.gain.high is not None]
    if not gains:
        return ""
    alone = len(v.judged) == 1
    step, what = ("The fall is", "This fall") if alone else ("The fall by the first cause alone is", "The fall by the first cause alone")
    return _fall_said(step, what, gains[0].low, gains[0].high, gains[0].before, gains[0].unit, v)


def _fall_said(step: str, what: str, low: float, high: float, before: float | None, unit: str, v: View) -> str:
    """The 95 % interval of a fall as a sentence; where it includes zero, that the fall may be chance."""
    if low > 0.0:
        return f"{step} {fall_span(low, high, before, unit, v.loudest)} with 95 % confidence."
    other = f"rise by {amount(-low, unit, like=v.loudest or None, digits=2)}" if low else "stay as it is"
    return f"{what} may be chance: the 95 % interval also allows the error to {other}."


def _where_it_lies(e: ChannelError, v: View) -> str:
    """A sentence with the errors of the taxel in which the first finding lies, where the large number is of another channel `e`."""
    own = next((o for o in v.errors if v.findings and o.channel == v.findings[0].where), None)
    if own is None or own.channel == e.channel or own.channel in v.silent or None in own.pair or not own.pair[0]:
        return ""
    both = " before, ".join(error(x, own, v) for x in own.pair)
    return f"{capital(spoken(own.channel))}, in which the first of the causes lies: {both} after."


def _bound(e: ChannelError, after: float, v: View) -> str:
    if e.floor is None:
        return ""
    floor = error(e.floor, e, v)
    if after <= ALIKE * e.floor:
        return "What is left is no more than noise."
    if v.verdict in (PARTLY, UNEXPLAINED):
        return f"Noise alone leaves about {floor}; the difference is still unexplained."
    return f"Noise alone leaves {floor}: " + ("there is nothing more to gain." if after < AT_FLOOR * e.floor else "no model can do better.")
