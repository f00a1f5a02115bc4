"""How what each session has of its own goes from session to session, in words: which sessions differ, and since when.

Numbers that lie on two levels step, if those on one of them are the last ones, or some of the sessions differ; numbers along a straight
line rise or fall. Of the two that is said which leaves less of them. For the rest there is the range.
"""

import re
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

FEWEST = 4  # sessions that make a pattern
APART, STEP = 8.0, 6.0  # standard deviations within two levels, by which these are apart, and where they follow one another
OF_FEW = 6.0  # over the squared degrees of freedom: how much more is asked of few sessions
STRAIGHT = 0.92  # of the variance, that a straight line explains where numbers rise steadily
IN_ORDER = 0.9  # rank correlation of numbers that rise on the whole
LISTED = 3  # sessions that are named one by one
NEARLY_NONE = 0.15  # of what one session has, up to which the others have nothing
RANGE = "between"  # what begins the words for numbers without a pattern
SIZES = {"1": ("{:+.1f} %", 1e2), "s": ("{:+.2f} ms", 1e3), "m": ("{:+.1f} µm", 1e6), "N": ("{:+.3g} N", 1.0)}


def in_order(names: Collection[str]) -> list[str]:
    """Names of sessions as they follow one another: by the numbers in them, where every one has some, or else as they are given."""
    return sorted(names, key=_natural) if all(re.search(r"\d", n) for n in names) else list(names)


def _natural(name: str) -> list:
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in re.split(r"(\d+)", name) if part]


def shown(names: Collection[str]) -> dict[str, str]:
    """By name of a session, how it is said: without the ending of a file that all of them share."""
    endings = {m[0] if (m := re.search(r"\.[a-z]\w{0,4}$", n)) else "" for n in names}
    ending = endings.pop() if len(endings) == 1 else ""
    return {n: n.removesuffix(ending) for n in names}


def when(some: Collection[str], every: Collection[str]) -> str:
    """In which of `every` session it is so: `from day18 on`, `until day09`, `in day13 alone`, `in 5 of 8 sessions`."""
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
    """The same as evidence of a finding: `only_in`, `not_in` and `pattern`; {} where it is so in every session."""
    free = [n for n in every if n not in some]
    has = [n for n in every if n in some]
    return {"only_in": has, "not_in": free, "pattern": when(some, every)} if has and free else {}


def listed(names: Sequence[str]) -> str:
    """`a, b and c`."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def pattern(values: Mapping[str, float], unit: str) -> str:
    """How numbers of sessions (by name, in the SI `unit`) go, as words that follow a noun; empty where they have no pattern or are few."""
    order, said = in_order(values), shown(values)
    y = np.array([values[n] for n in order])
    if len(y) < FEWEST or np.ptp(y) == 0.0:
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
    in_line = abs(np.corrcoef(ranks, np.arange(len(y)))[0, 1]) > IN_ORDER and len(y) > FEWEST
    return f"{verb} on the whole {ends}" if in_line else ""


def span(values: Collection[float], unit: str) -> str:
    """The range of numbers in the SI `unit`, as words that follow a noun: `between −3.6 % and +1.2 %`."""
    return f"{RANGE} {size(min(values), unit)} and {size(max(values), unit)}"


def size(value: float, unit: str) -> str:
    """A number with its sign and unit: `−3.6 %`."""
    form, scale = SIZES.get(unit, ("{:+.3g} " + unit, 1.0))
    return form.format(scale * value).replace("-", "−")


def _upper_level(y: np.ndarray) -> np.ndarray | None:
    """Which of the numbers are on the upper of two levels; None where they are not on two."""
    cuts = [y > level for level in np.sort(y)[:-1] if (y > level).any()]
    best = min(cuts, key=lambda upper: _left(y, upper))
    free = len(y) - 2
    within = np.sqrt(_left(y, best) / free)
    apart = STEP if np.count_nonzero(best[1:] != best[:-1]) == 1 else APART
    return best if y[best].mean() - y[~best].mean() > apart * (1.0 + OF_FEW / free**2) * within else None


def _left(y: np.ndarray, upper: np.ndarray) -> float:
    """Squares that two levels leave."""
    return float(sum(np.sum((part - part.mean()) ** 2) for part in (y[upper], y[~upper])))


def _on_two_levels(y: np.ndarray, upper: np.ndarray, order: list[str], unit: str) -> str:
    """Numbers on two levels, by session in `order`, in words: a step, one odd session, or some that differ."""
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
