"""The size of a finding in words: its parameters, or given numbers of a model beside the fitted ones."""

from skin_ident.criticism.pattern import listed
from skin_ident.criticism.telling.telling import MOVED_ERRORS, MOVED_SHARE
from skin_ident.report.numbers import amount, finite, percent
from skin_ident.report.tolerant import mapping, text
from skin_ident.report.view import Amount, Finding, View

MOST_AMOUNTS = 4  # parameters of a finding that are listed
LEAST = 2.0  # standard errors by which a parameter must differ from its neutral value to be listed
BRIEFLY = 2  # parameters that are listed where many findings share the first screen
AT_END = "at the end of its range"
GIVEN, MEASURED = 4, 3  # digits of a number without a standard error: of a given one, of a fitted one


def sizes(f: Finding, v: View, most: int = MOST_AMOUNTS, brief: bool = False) -> list[str]:
    """The sizes of a finding, such as `relaxation time 0.800 s`, the most important first. Parameters that are not significantly different
    from their neutral value are left out. With `brief` only the first BRIEFLY are listed, without the note that there are more."""
    said = put_right(v) if f.cause == "parameters" and v.given else _silent(f)
    told = [a for a in f.amounts if _tells(a)] or f.amounts
    if not said and (told := [a for a in told if a.value]):
        shown = _shown(told, BRIEFLY if brief else most)
        said, hidden = [_with_end(f"{a.words} {amount(a.value, a.unit, a.std)}", a) for a in shown], len(told) - len(shown)
        return said + ([f"and {hidden} more"] if hidden and not brief else [])
    said = said or _of_each_session(f)
    more = [] if brief or len(said) <= most else [f"and {len(said) - most} more"]
    return said[: BRIEFLY if brief else most] + more


def rival_sizes(f: Finding, which: int, brief: bool = False) -> list[str]:
    """The sizes of an alternative (number `which`) of a finding, where it was fitted."""
    amounts = f.rival_amounts[which] if which < len(f.rival_amounts) else ()
    told = [a for a in amounts if a.value and not a.is_rounding]
    return [_with_end(f"{a.words} {amount(a.value, a.unit)}", a) for a in _shown(told, BRIEFLY if brief else MOST_AMOUNTS)]


def _shown(told: list[Amount], most: int) -> list[Amount]:
    """The first `most` of the amounts, and all that lie at the end of their range: sizes beside such a number are not to be trusted."""
    return [a for i, a in enumerate(told) if i < most or a.at_end]


def _with_end(said: str, a: Amount) -> str:
    return said + f", {AT_END}" * a.at_end


def _tells(a: Amount) -> bool:
    """Whether a parameter differs significantly from its neutral value, or is not known."""
    return a.value is None or (not a.is_rounding and (not a.std or abs(a.value - a.none) > LEAST * a.std))


def put_right(v: View) -> list[str]:
    """Given numbers that were wrong, beside the fitted ones, the largest relative change first. Where none changed significantly, all that
    changed at all."""
    before = {a.name: a for a in v.before}
    pairs = [(before[a.name], a) for a in v.after if a.name in before and a.value != before[a.name].value]
    pairs.sort(key=lambda pair: -abs(step(*pair) or 0.0))
    return [_instead(*pair) for pair in [p for p in pairs if moved(*p)] or pairs]


def _instead(given: Amount, found: Amount) -> str:
    name = found.words if "." in found.name else found.name
    share = step(given, found)
    off = "" if share is None else f" ({'+' if share > 0 else ''}{percent(share)})"
    was = amount(given.value, given.unit, like=[found.value], digits=GIVEN)
    return f"{name} {amount(found.value, found.unit, found.std)} instead of {was}{off}"


def number(a: Amount, v: View, like: list | None = None) -> str:
    """A parameter of the model as text. A given one has one digit more, since no standard error says how many digits count."""
    given = v.given and any(b.name == a.name for b in v.before)
    return _with_end(amount(a.value, a.unit, a.std, like, GIVEN if given else MEASURED), a)


def _silent(f: Finding) -> list[str]:
    """For a taxel that is dead in some sessions only: in which, and since when."""
    since = {n: finite(s) or 0.0 for n, s in mapping(dict(f.evidence).get("dead_from_s")).items()} if f.partly else {}
    dying = [f"silent in {n} from {amount(s, 's')} on" for n, s in since.items() if s != 0.0]
    dead = [n for n, s in since.items() if s == 0.0]
    return dying + ([f"throughout {listed(dead)}" if dying else f"silent throughout {listed(dead)}"] if dead else [])


def _of_each_session(f: Finding) -> list[str]:
    """What each session has of its own; where they are many or follow a pattern, the pattern from one session to the next."""
    each = f.each_session
    if f.has_pattern or (f.goes and len(each) > MOST_AMOUNTS):
        return [f.goes]
    return [f"{session}: {text(course)}" for session, course in each.items()]


def step(before: Amount, after: Amount | None) -> float | None:
    """The relative change of a parameter; None where it is not known, or where the value before is zero."""
    if after is None or before.value is None or after.value is None or before.value == 0.0:
        return None
    return (after.value - before.value) / abs(before.value)


def moved(before: Amount, after: Amount | None) -> bool:
    """Whether a parameter changed significantly: by more than three standard errors and 5 %."""
    share = step(before, after)
    if share is None:
        return False
    spread = ((before.std or 0.0) ** 2 + (after.std or 0.0) ** 2) ** 0.5
    return abs(share) > MOVED_SHARE and abs(after.value - before.value) > MOVED_ERRORS * spread
