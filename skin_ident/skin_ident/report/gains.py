"""How much better the extended model is: the number that stands out on the first screen, and the sentences that hold it."""

from dataclasses import dataclass

from skin_ident.report.numbers import amount, percent, span
from skin_ident.report.view import ChannelError, View
from skin_ident.report.words import signal


@dataclass(frozen=True)
class Figure:
    """A number, what it is, and the sentences behind it."""

    number: str
    caption: str
    sentences: tuple[str, ...]


def better(v: View) -> Figure:
    """The gain in the channel that the first finding names, or in the one that gained most."""
    told = [e for e in v.errors if None not in e.pair and e.pair[0]]
    if not told:
        return Figure("Not measured", "", ("No simulation was compared with these data.",) if not v.errors else ())
    if not v.findings or not any(f.gain.before is not None or abs(fall(e)) > 1e-3 for f in v.findings for e in told):
        return _no_gain(v, told)
    named = [f.gain.channel for f in v.findings if f.gain.before is not None]
    return _gain(next((e for e in told if named and e.channel == named[0]), None) or max(told, key=fall), v)


def fall(e: ChannelError) -> float:
    """Relative fall of a channel's error, on held-out data where it is known."""
    before, after = e.pair
    return 1.0 - after / before if before and after is not None else 0.0


def _no_gain(v: View, told: list[ChannelError]) -> Figure:
    """Nothing was added: where the model stands against the noise."""
    at_noise = all(e.floor is not None and e.pair[1] < 1.15 * e.floor for e in told)
    said = [f"Typical error of the {signal(e.channel)}: {amount(e.pair[1], e.unit)}." + _floor(e) for e in told[:2]]
    if v.findings:
        return Figure("No change", "the named faults are in the record, not in the model", tuple(said))
    return Figure("Nothing to gain" if at_noise else "No gain", "" if at_noise else "no cause could be added to the model", tuple(said))


def _floor(e: ChannelError) -> str:
    return "" if e.floor is None else f" Noise alone leaves {amount(e.floor, e.unit, like=[*e.pair, e.floor])}."


def _gain(e: ChannelError, v: View) -> Figure:
    before, after = e.pair
    tested = None not in e.held_out
    where = "data not used for fitting" if tested else "the data it was fitted to"
    caption = f"{'less' if fall(e) >= 0 else 'more'} error in the {signal(e.channel)}, on {where}"
    said = [
        f"Typical error: {amount(before, e.unit, like=e.pair)} before, {amount(after, e.unit, like=e.pair)} after.",
        _interval(v, e),
        _bound(e),
    ]
    return Figure(percent(abs(fall(e))), caption, tuple(s for s in said if s))


def _interval(v: View, e: ChannelError) -> str:
    gains = [f.gain for f in v.findings if f.gain.channel == e.channel and f.gain.low is not None and f.gain.high is not None]
    if not gains:
        return ""
    step = "The fall is" if len(v.findings) == 1 else "The first cause alone is worth"
    return f"{step} {span(gains[0].low, gains[0].high, gains[0].unit)} with 95 % confidence."


def _bound(e: ChannelError) -> str:
    if e.floor is None:
        return ""
    near = e.pair[1] is not None and e.pair[1] < 1.15 * e.floor
    rest = "there is nothing more to gain." if near else "no model can do better than that."
    return f"Noise alone leaves {amount(e.floor, e.unit, like=[*e.pair, e.floor])}: {rest}"
