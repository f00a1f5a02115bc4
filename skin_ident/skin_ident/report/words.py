"""Words for a reader who has never seen findings.json: places, channels, causes, verdicts, and whether a sensor must be rebuilt."""

from dataclasses import dataclass
from functools import cache

from skin_ident.criticism.vocabulary import BY_NAME
from skin_models.catalogue import effects
from skin_models.dispersion import Dispersion
from skin_models.parameter import parameters_of

PLACES = {
    "skin": "the skin",
    "rig": "the rig",
    "load_cell": "the load cell",
    "taxel": "the taxels, all alike",
    "clock": "the clock",
    "clock_taxels": "the clock of the taxels",
    "clock_depth": "the clock of the encoder",
}


def spoken(name: str) -> str:
    """A name of code as words: `stress_relaxation` becomes `stress relaxation`."""
    return str(name).replace("_", " ").strip()


def place(where: str) -> str:
    """Where something sits: `taxel_3` becomes `taxel 3 alone`."""
    head, _, index = str(where).partition("_")
    if head == "taxel" and index.isdigit():
        return f"taxel {index} alone"
    return PLACES.get(where, spoken(where))


def channel(name: str) -> str:
    """A measured channel."""
    return "force (load cell)" if name == "force" else spoken(name)


def cause_at(cause: str, where: str) -> str:
    """`stress relaxation in the skin`."""
    return f"{spoken(cause)} in {place(where)}" if where else spoken(cause)


def meaning(cause: str) -> str:
    """What a cause means, in words that follow a colon; empty for one that the vocabulary does not hold."""
    return BY_NAME[cause].means if cause in BY_NAME else ""


def advice(cause: str) -> str:
    """What to do about a cause."""
    return BY_NAME[cause].act if cause in BY_NAME else ""


def capital(text: str) -> str:
    """The text with its first letter in upper case."""
    return text[:1].upper() + text[1:]


def sentence(text: str) -> str:
    """The text as a sentence: a capital in front, a full stop behind."""
    text = text.strip()
    return capital(text) + ("" if not text or text[-1] in ".!?…" else ".")


@cache
def parameter_words(name: str) -> str:
    """What a parameter of the dispersion model is."""
    return {p.name: p.doc for p in parameters_of(Dispersion)}.get(name, "")


@cache
def effect_words(cause: str, where: str, name: str) -> str:
    """What a parameter of an effect is, from the effect's own declaration; an arm's number (`tau_2`) is kept."""
    word = "taxel" if where.startswith("taxel") else where
    stem, _, number = name.rpartition("_")
    for cls in effects():
        if cls.cause == cause and word in cls.places:
            docs = {p.name: p.doc for p in parameters_of(cls)}
            if name in docs:
                return docs[name]
            if number.isdigit() and stem in docs:
                return f"{docs[stem]}, number {number}"
    return ""


@dataclass(frozen=True)
class Rebuild:
    """Whether a finding asks for new hardware: `answer` is yes, perhaps or no."""

    answer: str
    because: str


_DISTORTING = {"hysteresis", "dead_zone", "saturation", "lag", "crosstalk", "quantization"}


def rebuild(cause: str, where: str) -> Rebuild:
    """Does this finding call for rebuilding a sensor?"""
    on_taxel = where.startswith("taxel")
    if cause == "dead_taxel":
        return Rebuild("yes", f"{place(where)} no longer answers")
    if cause == "data_error":
        return Rebuild("cannot say", "the record itself is wrong, so it proves nothing about the sensor")
    if on_taxel and cause in _DISTORTING:
        return Rebuild(
            "perhaps", "the sensor itself bends its signal; rebuild only if the corrected model is not good enough for your task"
        )
    if on_taxel:
        return Rebuild("no", "the sensor works; its calibration, zero or wiring needs attention")
    said = {
        "skin": "the skin behaves like this and the model can learn it; the sensors read correctly",
        "rig": "the test rig is at fault, not the sensor",
        "load_cell": "the reference load cell is at fault, not the skin's sensors",
    }
    return Rebuild("no", said.get(where, "timing is at fault, not the sensor" if where.startswith("clock") else "no sensor is implicated"))
