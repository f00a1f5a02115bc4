"""The pattern of numbers over sessions, in words: which sessions differ, and since when.

Numbers on two levels are described as a step if one level is that of the last sessions, else as sessions that differ. Numbers along a
straight line rise or fall. Of the two descriptions the one with the smaller residual is given. Without a pattern only the range is given.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

FEWEST_SESSIONS = 4  # sessions needed for a pattern
APART, STEP = 8.0, 6.0  # distance of two levels in standard deviations within them, in any order, and as one step in time
OF_FEW = 6.0  # over the squared degrees of freedom: relative increase of that distance for few sessions
STRAIGHT = 0.92  # share of the variance that a straight line explains if numbers rise steadily
IN_ORDER = 0.9  # rank correlation with time of numbers that rise on the whole
LISTED = 3  # up to so many sessions are listed by name
NEARLY_NONE = 0.15  # of one session's number, up to which the others count as zero
RANGE = "between"  # first word for numbers without a pattern
SIZES = {"1": ("{:+.1f} %", 1e2), "s": ("{:+.2f} ms", 1e3), "m": ("{:+.1f} µm", 1e6), "N": ("{:+.3g} N", 1.0)}


def in_order(names: Collection[str]) -> list[str]:
    """Names of sessions in order: by the numbers in them, if each has one, else as given."""
    return sorted(names, key=_natural) if all(re.search(r"\d", n) for n in names) else list(names)


def _natural(name: str) -> list:
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", name) if part]


def shown(names: Collection[str]) -> dict[str, str]:
    """How each session's name is shown: without a file extension that all share."""
    endings = {m[0] if (m := re.search(r"\.[a-z]\w{0,4}$", n)) else "" for n in names}
    ending = endings.pop() if len(endings) == 1 else ""
    return {n: n.removesuffix(ending) for n in names}


def when(some: Collection[str], every: Collection[str]) -> str:
    """In which of `every` session something holds: `from day18 on`, `until day09`, `in day13 alone`, `in 5 of 8 sessions`."""
    order, said = in_order(every), shown(every)
    has = [n in some for n in order]
    at = [i for i, h in enumerate(has) if h]
    named = [said[order[i]] for i in at]
    if len(at) in (0, len(order)):
        return "in every session" if at else "in no session"
    if len(at) == 1:
        return f"in {named[0]} alone"
    together = at[-1] - at[0] == len(at) - 1
    if together and at[-1] == len(order) - 1:
        return f"from {named[0]} on"
    if together and at[0] == 0:
        return f"until {named[-1]}"
    if len(at) == len(order) - 1:
        return f"in all but {said[order[has.index(False)]]}"
    if together and len(at) > 2:
        return f"from {named[0]} to {named[-1]}"
    return f"in {listed(named)}" if len(at) <= LISTED else f"in {len(at)} of {len(order)} sessions"


def in_sessions(some: Collection[str], every: Collection[str]) -> dict[str, Any]:
    """The same as evidence of a finding: `only_in`, `not_in` and `pattern`; {} where it holds in every session, or in none."""
    free = [n for n in every if n not in some]
    has = [n for n in every if n in some]
    return {"only_in": has, "not_in": free, "pattern": when(some, every)} if has and free else {}


def listed(names: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def pattern(values: Mapping[str, float], unit: str) -> str:
    """The pattern of numbers by session (in the SI `unit`), as words that follow a noun; "" where there is none or sessions are few."""
    order, said = in_order(values), shown(values)
    y = np.array([values[n] for n in order])
    if len(y) < FEWEST_SESSIONS or np.ptp(y) == 0.0:
        return ""
    upper = _upper_level(y)
    line = np.polyval(np.polyfit(np.arange(len(y)), y, 1), np.arange(len(y)))
    if upper is not None and _left(y, upper) <= np.sum((y - line) ** 2):
        return _on_two_levels(y, upper, order, unit)
    verb = "rises" if line[-1] > line[0] else "falls"
    ends = f"from {size(y[0], unit)} ({said[order[0]]}) to {size(y[-1], unit)} ({said[order[-1]]})"
    if 1.0 - np.sum((y - line) ** 2) / np.sum((y - y.mean()) ** 2) > STRAIGHT:
        return f"{verb} steadily {ends}"
    ranks = np.argsort(np.argsort(y))
    in_line = abs(np.corrcoef(ranks, np.arange(len(y)))[0, 1]) > IN_ORDER and len(y) > FEWEST_SESSIONS
    return f"{verb} on the whole {ends}" if in_line else ""


def span(values: Collection[float], unit: str) -> str:
    """The range of numbers in the SI `unit`, as words that follow a noun: `between −3.6 % and +1.2 %`."""
    return f"{RANGE} {size(min(values), unit)} and {size(max(values), unit)}"


def size(value: float, unit: str) -> str:
    """A number with its sign and unit: `−3.6 %`."""
    form, scale = SIZES.get(unit, ("{:+.3g} " + unit, 1.0))
    return form.format(scale * value).replace("-", "−")


def _upper_level(y: np.ndarray) -> np.ndarray | None:
    """Mask of the numbers on the upper of two levels; None where there are not two clear levels."""
    cuts = [y > level for level in np.sort(y)[:-1] if (y > level).any()]
    best = min(cuts, key=lambda upper: _left(y, upper))
    free = len(y) - 2
    within = np.sqrt(_left(y, best) / free)
    apart = STEP if np.count_nonzero(best[1:] != best[:-1]) == 1 else APART
    return best if y[best].mean() - y[~best].mean() > apart * (1.0 + OF_FEW / free**2) * within else None


def _left(y: np.ndarray, upper: np.ndarray) -> float:
    """Sum of squares within two levels."""
    return float(sum(np.sum((part - part.mean()) ** 2) for part in (y[upper], y[~upper])))


def _on_two_levels(y: np.ndarray, upper: np.ndarray, order: list[str], unit: str) -> str:
    """Numbers on two levels, by session in `order`, in words: a step, one odd session, or several that differ."""
    first = upper[0]
    changes = np.flatnonzero(upper[1:] != upper[:-1])
    before, after = y[upper == first], y[upper != first]
    if len(changes) == 1 and min(len(before), len(after)) > 1:
        step = after.mean() - before.mean()
        ends = f"from {size(before.mean(), unit)} to {size(after.mean(), unit)}"
        return f"steps by {size(step, unit)} at {shown(order)[order[changes[0] + 1]]}, {ends}"
    differs = upper if 2 * np.count_nonzero(upper) <= len(y) else ~upper
    some = [n for n, d in zip(order, differs, strict=True) if d]
    own, others = y[differs].mean(), y[~differs].mean()
    if len(some) == 1 and np.abs(y[~differs]).max() < NEARLY_NONE * abs(own):
        return f"is {size(own, unit)} {when(some, order)}"
    return f"differs by {size(own - others, unit)} {when(some, order)}"
