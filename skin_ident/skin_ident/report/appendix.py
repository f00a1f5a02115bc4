"""The last sections of the page: parameters, what was ruled out, what could not be tested, the recordings, and a glossary."""

from collections.abc import Iterator

from skin_ident.criticism.vocabulary import BY_NAME, spoken
from skin_ident.report.bars import parameter_table
from skin_ident.report.markup import Safe, el, join, section, table
from skin_ident.report.numbers import amount, finite, percent
from skin_ident.report.reading import recording_name, warning_sentences
from skin_ident.report.ruled_out import bound, strongly, weakly
from skin_ident.report.tolerant import mapping, named_at, place_in, sequence, text, with_spoken_taxels
from skin_ident.report.view import View
from skin_ident.report.words import capital, meaning, role, sentence, undivided

SPREAD = "Standard errors contain noise only. They do not contain errors of the form of the model, which every model of a real skin has."
TWO_SIZES = "A second size holds for those values of the cause's other parameters that would show most."
ONLY_WEAKLY = "Ruled out only weakly"
WEAK_HEAD = ["cause", "smaller than", "would need"]
WEAK_NOTE = (
    "These were not found, either, but as much as the size given may be there without having shown, and that is more than a quarter of "
    f"the skin's stiffness, of the largest force, of the greatest depth or of the whole signal. {TWO_SIZES}"
)
MOST_ROWS = 15  # a longer table is folded
ELSEWHERE = ("by_itself", "rmse", "stands_out")  # entries of a recording that `sessions` shows
GIVEN = {False: "that was given", True: "that was recorded as a twin"}  # key: whether the given simulation is a twin
GIVEN_NUMBERS = {False: "were given", True: "are those of a model fitted to the recorded twin"}  # likewise


def parameters(v: View) -> Safe | None:
    """The section of the model's parameters before and after; None where neither is known."""
    if not v.before and not v.after:
        return None
    note = (
        "When an effect is missing from the model, the fit changes the other parameters to compensate. Those that changed by more than "
        "three standard errors (and 5 %) are marked: the missing effect had biased their old values."
    )
    if v.given:
        note = (
            f"The numbers before {GIVEN_NUMBERS[v.is_twin]}; they were not fitted to these data, so they have no standard error. The "
            "numbers after were fitted to these data, or are the same where these data require no change. Those that differ by more than "
            "three standard errors (and 5 %) are marked."
        )
    elif [(a.name, a.value) for a in v.before] == [(a.name, a.value) for a in v.after]:
        note = "Nothing was added to the model, so its parameters stay as they were."
    elif not v.findings:
        own = f"; after: with each session's own {' and '.join(v.own_zeros)}, which is not a fault" if v.own_zeros else ""
        note = f"Nothing was added to the model. Before: as it was fitted first{own}."
    note += f" {SPREAD}"
    held = [el("p", sentence(said), class_="note") for said in held_at(v)]
    return section("parameters", "Parameters before and after", el("p", note, class_="note"), parameter_table(v), held)


def held_at(v: View) -> list[str]:
    """Sentences about parameters that were held and not fitted: their values and where these come from."""
    return [f"{a.words} was not fitted: it is held at {amount(a.value, a.unit)}, {source}" for a, source in v.held]


def excluded(v: View) -> Safe | None:
    """The section of causes that were tested and not found, with the upper bound of each."""
    if not v.excluded:
        return None
    strong, weak = strongly(v), weakly(v)
    rows = [[_name(e), size_ruled_out(e, v), sentence(meaning(text(e.get("cause"))))] for e in strong]
    note = "These were tested and not found. If one of them were present and larger than the size given, these data would have shown it."
    note += f" {TWO_SIZES}"
    body = table(["cause", "smaller than", "what it would mean"], rows, class_="plain")
    return section(
        "excluded",
        "Ruled out",
        [el("p", note, class_="note"), _folded(body, strong)] if strong else None,
        [el("h3", ONLY_WEAKLY), el("p", WEAK_NOTE, class_="note"), table(WEAK_HEAD, weak_rows(v), class_="plain")] if weak else None,
    )


def weak_rows(v: View) -> list[list[str]]:
    """Rows of (cause, size below which it may be there unseen, what would show less of it)."""

    def needs(e: dict) -> str:
        known = BY_NAME.get(text(e.get("cause")))
        return text(e.get("needs")) or (known.needs if known else "")

    return [[_name(e), size_ruled_out(e, v), sentence(needs(e))] for e in weakly(v)]


def _also(e: dict, others: tuple[dict, ...]) -> list[dict]:
    """The entries of `others` about the same cause at the same place; an entry without a place matches any."""

    def named(x: dict) -> tuple[str, str]:
        return text(x.get("cause")), place_in(x)

    return [o for o in others if named(o) == named(e) or (named(o)[0] == named(e)[0] and not (named(o)[1] and named(e)[1]))]


def size_ruled_out(e: dict, v: View) -> str:
    """The upper bound of an excluded cause, in words, and whether part of the cause could not be tested."""
    limit = f"; limited by {text(e['limited_by'])}" if e.get("limited_by") else ""
    ruled_out = undivided(bound(e, v)) if v.alone else bound(e, v)
    return ruled_out + limit + ("; only in part, see what could not be tested" if _also(e, v.untestable) else "")


def why_untestable(e: dict, v: View) -> str:
    """Why a cause could not be tested, as a sentence. Where some of its forms were ruled out, it says that the reason is about the rest."""
    because, ruled_out = with_spoken_taxels(text(e.get("because"))), _also(e, v.excluded)
    if not ruled_out or "form" in e:  # an entry with a form already says that it is about this form only
        return sentence(because)
    forms = " and ".join(dict.fromkeys(spoken(text(o.get("form"))) for o in ruled_out if o.get("form")))
    return f"Ruled out in part only{f' (its form {forms})' if forms else ''}: {because.rstrip('.')}."


def untestable_rows(v: View) -> Iterator[tuple[str, str, str]]:
    """Rows of (causes, why they could not be tested, what would test them). Causes at one place share a row where both are the same."""
    rows: dict[tuple[str, str, str], list[dict]] = {}
    for e in v.untestable:
        shared = place_in(e), why_untestable(e, v), with_spoken_taxels(text(e.get("needs")))
        rows.setdefault(shared, []).append(e)
    for (_, why, needs), (*others, last) in rows.items():
        names = [spoken(text(e.get("cause"))) for e in others]
        yield f"{', '.join(names)}{' and ' if names else ''}{named_at(last)}", why, needs


def _folded(body: Safe, entries: tuple[dict, ...]) -> Safe:
    """The table, folded behind a summary where it has more than MOST_ROWS rows."""
    if len(entries) <= MOST_ROWS:
        return body
    causes = dict.fromkeys(spoken(text(e.get("cause"))) for e in entries)
    return el("details", el("summary", f"{len(causes)} causes, in all the places where they could be: {', '.join(causes)}"), body)


def _name(e: dict) -> str:
    return capital(named_at(e))


def untestable(v: View) -> Safe | None:
    """The section of causes that these data could not show."""
    if not v.untestable:
        return None
    rows = [[capital(names), why, sentence(needs)] for names, why, needs in untestable_rows(v)]
    note = "These data neither confirm nor exclude these causes, for the reason given."
    if any(_also(e, v.excluded) for e in v.untestable):
        note += " Where a cause is also listed as ruled out, this is about the part of it that was not ruled out."
    return section(
        "untestable", "Could not be tested", el("p", note, class_="note"), table(["cause", "because", "would need"], rows, (), "plain")
    )


def recordings(v: View) -> Safe | None:
    """The section of the recordings that were read, with their warnings."""
    said = set(v.warnings)
    items = [el("li", _recording(r, said)) for r in v.recordings]
    warned = [el("p", el("b", "Warnings")), el("ul", [el("li", w) for w in warning_sentences(v)])] if v.warnings else []
    rest = [[el("dt", spoken(k)), el("dd", text(x))] for k, x in v.other.items() if x not in (None, "", [], {})]
    more = el("details", el("summary", "More from findings.json"), el("dl", rest)) if rest else None
    return section("recordings", "Recordings", el("ul", items), warned, more) if items or warned or more else None


def _recording(r, said: set[str]) -> Safe:
    name = recording_name(r)
    facts = [*_facts(mapping(r))]
    warnings = [w for w in map(text, sequence(mapping(r).get("warnings"))) if w not in said and f"{name}: {w}" not in said]
    return join(
        [
            el("b", name),
            f" – {', '.join(facts)}" if facts else "",
            el("ul", [el("li", sentence(w)) for w in warnings]) if warnings else None,
        ]
    )


def _facts(r: dict) -> Iterator[str]:
    """Facts about a recording, in words."""
    known = {"name", "session", "path", "warnings", "seconds", "samples", "rate_hz", "held_out", "compared", *ELSEWHERE}
    if r.get("seconds") is not None:
        yield amount(r["seconds"], "s")
    if r.get("samples") is not None:
        yield f"{text(r['samples'])} samples" + (f" at {amount(r['rate_hz'], 'Hz')}" if r.get("rate_hz") is not None else "")
    if isinstance(r.get("held_out"), bool):
        yield role(r["held_out"])
    seen = mapping(r.get("compared"))
    if finite(seen.get("left_out")):
        share = percent(seen["left_out"] / (seen["left_out"] + (finite(seen.get("samples")) or 0.0)))
        yield f"{share} of it not compared ({text(seen.get('because'))})"
    yield from (f"{spoken(k)} {text(x)}" for k, x in r.items() if k not in known and x not in (None, "", [], {}))


def _before_after(v: View) -> str:
    """What the words before and after mean: the two simulations that are compared."""
    if v.given:
        return f"before: the simulation {GIVEN[v.is_twin]}, not fitted to these data; after: with what is named here, fitted to them"
    return "the simulation without and with the causes named here, both fitted to the same data"


def reading(v: View, folder: str) -> Safe:
    """The glossary, and where the other files are. `folder` holds the files of the diagnosis where they are not beside the page. There is
    no model where too few samples could be trusted."""
    words = (
        *([("before, after", _before_after(v))] if v.findings else []),
        ("measured − simulated", "what the simulation misses; zero is perfect"),
        ("typical error", "root mean square of measured − simulated"),
        ("data not used for fitting", "a session kept aside: a model that merely memorised the other sessions would fail on it"),
        (
            "95 % interval",
            "if the experiment were repeated, the fall of the error would lie in it 19 times out of 20 (block bootstrap). An error "
            "cannot fall by more than its value before; of an interval that reaches beyond that value, only the lower end is given",
        ),
        ("noise alone", "the error that would remain with a perfect model, because sensors are noisy"),
        ("at the end of its range", "the fit would have gone further; such a number, and the sizes beside it, cannot be taken literally"),
        ("ruled out", "tested and not found; would have been seen above the size given"),
        ("could not be tested", "for the reason given: the motion does not excite it, it is not declared, or it looks like another cause"),
        ("where", "skin: the material; taxel: a sensor in it; load cell: the reference; rig: mount and stage; clock: timing of a channel"),
    )  # fmt: skip
    model = ", model.yaml (the extended model)" if v.has_model else ""
    kept = f"findings.json (everything here, for programs){model} and traces.npz (the curves)"
    text_too = "report.md and pictures (for a mail)"
    files = f"Beside this file: {text_too}. In {folder}: {kept}." if folder else f"Beside this file: {text_too}, {kept}."
    return section(
        "reading",
        "How to read this",
        el("dl", [[el("dt", k), el("dd", sentence(w))] for k, w in words], class_="gloss"),
        el("p", files, class_="note"),
    )
