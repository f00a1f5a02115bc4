"""Words for a reader who has never seen findings.json: channels, parameters, evidence, and whether a sensor must be rebuilt."""

import re
from dataclasses import dataclass
from functools import cache

from skin_ident.criticism.array.proposing import OF_ARRAY
from skin_ident.criticism.vocabulary import BY_NAME, place, place_of, spoken, word_of
from skin_models.catalogue import effects
from skin_models.dispersion import Dispersion
from skin_models.effect import Effect
from skin_models.parameter import Parameter, parameters_of


def channel(name: str) -> str:
    """Words for a measured channel."""
    return "force (load cell)" if name == "force" else spoken(name)


def signal(name: str) -> str:
    """Words for a channel inside a sentence, to follow `the simulated`: `force`, `signal of taxel 0`."""
    return "force" if name == "force" else f"signal of {spoken(name)}"


def role(held_out: bool) -> str:
    """What a session was for."""
    return "not used for fitting" if held_out else "used for fitting"


def short(name: str, most: int = 48) -> str:
    """The name, without its middle where it is longer than `most` characters."""
    return name if len(name) <= most else f"{name[: most // 2]}…{name[-most // 2 + 1 :]}"


def meaning(cause: str) -> str:
    """What a cause means, in words that follow a colon; empty for a cause that is not in the vocabulary."""
    return BY_NAME[cause].means if cause in BY_NAME else ""


def advice(cause: str) -> str:
    """What to do about a cause; empty for a cause that is not in the vocabulary."""
    return BY_NAME[cause].act if cause in BY_NAME else ""


# Matches text whose first word is the name of a file, a session or a channel: `rig.yaml`, `session_1`, `data/a.csv`.
_NAME = re.compile(r"[\w-]+[._/\\]\w")


def either(names: list[str], most: int = 9) -> str:
    """`a, b or c`; of more than `most` names only the first ones, and how many others there are."""
    shown = names if len(names) <= most else [*names[: most - 1], f"{len(names) - most + 1} others"]
    return " or ".join(filter(None, (", ".join(shown[:-1]), shown[-1])))


def capital(text: str) -> str:
    """The text with its first letter in upper case, unless it begins with a name, which is written as it is."""
    return text if _NAME.match(text) else text[:1].upper() + text[1:]


def sentence(text: str, begins_with_name: bool = False) -> str:
    """The text as a sentence: with a full stop, and a capital unless it begins with a name."""
    text = text.strip()
    return (text if begins_with_name else capital(text)) + ("" if not text or text[-1] in ".!?…" else ".")


@cache
def parameter_words(name: str) -> str:
    """Words for a parameter of the dispersion model; empty for any other."""
    return {p.name: p.doc for p in parameters_of(Dispersion)}.get(name, "")


# Words for parameters of the criticism of static scans, by their names in findings.json.
_OF_SCANS = {
    "width": "width of the spread",
    "width_at_surface": "width of the spread at the surface",
    "width_ratio": "ratio of the widths of the two directions",
    "growth": "growth of the width with depth",
    "depth_power": "exponent of the depth in the width of the spread (0: constant width)",
    "shape_power": "exponent of the distance in the fall of the spread (2: a Gaussian)",
    "power": "exponent of the distance in the fall of the spread, minus the 2 of a Gaussian",
    "tail_weight": "weight of the spread's tail (0: a Gaussian)",
    "disc_radius": "radius of the disc that presses",
    "centre": "centre of the spread",
    "exponent": "exponent of the depth in the force (1: linear)",
    "square": "force proportional to depth squared, divided by the linear force, at the greatest depth",
    "cube": "force proportional to depth cubed, divided by the linear force, at the greatest depth",
    "shift": "shift of the zero of depth",
    "drift": "drift over the scan",
    "drift_over_the_scan": "drift over the scan",
    "level_factor": "factor on the forces of the given model",
}


def label(name: str) -> str:
    """Words for a parameter of the model: `k1`, `share_2`, or `k1_2`, which is `k1` of the second of several scans."""
    if name.startswith("share_"):
        return f"share of the sensed force that reaches taxel {name[6:]}"
    own = parameter_words(name) or _OF_SCANS.get(name, "")
    of_one = "" if own else label(_stem(name)) if _stem(name) in ("k1", "level_factor") else ""
    return own or (f"{of_one}, scan {name.rpartition('_')[2]}" if of_one else spoken(name))


# Matches a symbol of the effect's equation after the word it stands for: "bias F", "time t0, counted from …".
_SYMBOL = re.compile(r"(?<!of)(?<!is)(?<!per)(?<!\d) (?:[A-Za-z]|tau|v_s|x0|x1|t0)(?=$|[ ,:;])")


_PARTS = {", sensed": " (felt by taxels)", ", dispersed": " (not felt by taxels)"}


def _without_symbols(doc: str) -> str:
    """A parameter's description without the symbols of the equation."""
    for sign, said in (("of x^2", "of depth squared"), ("of x^3", "of depth cubed"), ("factor of x v", "damping that grows with depth")):
        doc = doc.replace(sign, said)
    plain = _SYMBOL.sub("", doc.partition(";")[0], count=1)
    for word, said in _PARTS.items():
        plain = plain[: -len(word)] + said if plain.endswith(word) else plain
    return plain


def undivided(words: str) -> str:
    """The words for a parameter where no taxel divides what the skin carries."""
    for said in _PARTS.values():
        words = words.replace(said, "")
    return words


# What a taxel repeats, by the form of crosstalk that the ratios of the taxels show.
_REPEATED = {
    "neighbours": "the neighbours' sum",
    "common": "the mean of all taxels",
    "previous": "the taxel that is read before",
    "previous_in_turn": "the taxel that is read before",
    "next": "the taxel that is read after",
    "next_in_turn": "the taxel that is read after",
    "one": "one other taxel",
}


@cache
def effect_words(cause: str, where: str, names: tuple[str, ...], forms: tuple[str, ...] = ()) -> dict[str, str]:
    """Words for the parameters `names` of an effect, from its own declaration; an arm's number (`tau_2`) is kept. Unknown names are absent.

    Where a cause has several forms, those in `forms` (their own names, or the names of their classes) come first, then the form that
    declares most of the names, and other forms for the rest: one name may mean different things in two forms.
    """
    words = {name: _of(p, name) for name, p in declared(cause, where, names, forms).items()}
    repeated = [_REPEATED[form] for form in forms if form in _REPEATED and cause == "crosstalk" and "share" in names]
    return words | ({"share": f"share of {repeated[-1]}"} if repeated else {})


@cache
def declared(cause: str, where: str, names: tuple[str, ...], forms: tuple[str, ...] = ()) -> dict[str, Parameter]:
    """The declared parameters `names` of an effect, those of its `forms` first; one of an arm (`tau_2`) is declared under its plain name.
    Unknown names are absent."""
    word = "taxel" if where.startswith("taxel") else word_of(where)
    classes = [c for c in (*OF_ARRAY, *effects()) if c.cause == cause and word in map(word_of, c.places)]
    said = [(c.form in forms or c.__name__ in forms, _declared_by(c, names)) for c in classes]
    return {name: p for _, of in sorted(said, key=lambda s: (s[0], len(s[1]))) for name, p in of.items()}


def _declared_by(form: type[Effect], names: tuple[str, ...]) -> dict[str, Parameter]:
    of = {p.name: p for p in parameters_of(form)}
    return {name: of[own] for name in names for own in (_stem(name), name) if own in of and of[own].doc}


def _stem(name: str) -> str:
    stem, _, number = name.rpartition("_")
    return stem if number.isdigit() else ""


def _of(p: Parameter, name: str) -> str:
    words = _without_symbols(p.doc)
    return words if p.name == name else f"{words}, number {name.rpartition('_')[2]}"


EVIDENCE = {
    "likelihood_gain": "Explains, in units of the noise",
    "held_out_fall_of_mean_square": "Fall of the squared error on unused data",
    "held_out_fall_over_distances": "Fall of the squared error at unused distances",
    "held_out": "Tested on",
    "forms": "Form",
    "explained_share": "Share of the mismatch explained",
    "log_likelihood_ratio": "Log likelihood ratio",
    "simulated": "In the simulation",
    "kind": "Kind",
}
SHARES = {"held_out_fall_of_mean_square", "held_out_fall_over_distances", "explained_share"}


@dataclass(frozen=True)
class Rebuild:
    """Whether a finding asks for a new sensor: `answer` is yes, perhaps, no or cannot say (or, with rivals, not before a test). `but` is
    hardware besides the taxels that may be at fault instead, and `checks` says how to check each of it."""

    answer: str
    because: str
    but: tuple[str, ...] = ()
    checks: tuple[str, ...] = ()


_OF_THE_RIG = {"mount_compliance": "the mount", "backlash": "the stage", "friction": "the guide of the plunger"}


def hardware(cause: str, where: str) -> str:
    """The hardware besides the taxels that a cause at a place would be a fault of; empty where it is none."""
    if where == "load_cell" or where.startswith("clock"):
        return place_of(cause, where)
    return _OF_THE_RIG.get(cause, "") if where == "rig" else ""


_DISTORTING = {"hysteresis", "dead_zone", "saturation", "lag", "crosstalk", "quantization"}


def rebuild(cause: str, where: str) -> Rebuild:
    """Whether a cause at a place calls for rebuilding a sensor."""
    on_taxel = where.startswith("taxel")
    if cause == "dead_taxel":
        return Rebuild("yes", f"{place(where)} no longer answers: {advice(cause)}")
    if cause == "data_error":
        return Rebuild("cannot say", "the record itself is wrong, so it proves nothing about the sensor")
    if on_taxel and cause in _DISTORTING:
        return Rebuild(
            "perhaps", "the sensor itself distorts its signal; rebuild only if the corrected model is not good enough for your task"
        )
    if on_taxel:
        return Rebuild("no", "the sensor works; its calibration, zero or wiring needs attention")
    said = {
        "skin": "the skin behaves like this, and a model can include it; nothing in these data indicates a fault of a sensor",
        "rig": "the test rig is at fault, not the sensor",
        "load_cell": "the reference load cell is at fault, not the skin's sensors",
    }
    return Rebuild("no", said.get(where, "timing is at fault, not the sensor" if where.startswith("clock") else "no sensor is implicated"))
