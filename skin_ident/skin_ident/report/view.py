"""findings.json as the report needs it: typed, complete, and forgiving about what an older or newer writer left out or added."""

from dataclasses import dataclass
from typing import Any

from skin_ident.report.numbers import finite, plain
from skin_ident.report.words import cause_at, effect_words, parameter_words, spoken


@dataclass(frozen=True)
class Amount:
    """One parameter: its name in code, what it is in words, SI value with unit and standard error (None where not known)."""

    name: str
    words: str
    value: float | None
    unit: str
    std: float | None = None


@dataclass(frozen=True)
class Gain:
    """Error on held-out data before and after; `low` and `high` bound the fall at 95 %."""

    before: float | None
    after: float | None
    low: float | None
    high: float | None
    channel: str
    unit: str
    held_out: str

    @property
    def fall(self) -> float | None:
        """Relative fall of the error."""
        return 1.0 - self.after / self.before if self.before and self.after is not None else None


@dataclass(frozen=True)
class Finding:
    """One named cause."""

    cause: str
    where: str
    channels: tuple[str, ...]
    amounts: tuple[Amount, ...]
    evidence: tuple[tuple[str, Any], ...]
    gain: Gain
    alternatives: tuple[tuple[str, str, str], ...]  # cause, where, remark
    separating: str


@dataclass(frozen=True)
class ChannelError:
    """Root mean squared error of one channel: baseline and extended model, on training and on held-out data; and the noise floor."""

    channel: str
    unit: str
    train: tuple[float | None, float | None]
    held_out: tuple[float | None, float | None]
    floor: float | None

    @property
    def pair(self) -> tuple[float | None, float | None]:
        """Before and after, held out where that is known."""
        return self.held_out if None not in self.held_out else self.train


@dataclass(frozen=True)
class View:
    """Everything that the report says, read once."""

    verdict: str
    model: str
    recordings: tuple[Any, ...]
    findings: tuple[Finding, ...]
    errors: tuple[ChannelError, ...]
    before: tuple[Amount, ...]
    after: tuple[Amount, ...]
    excluded: tuple[dict[str, Any], ...]
    untestable: tuple[dict[str, Any], ...]
    warnings: tuple[str, ...]
    other: dict[str, Any]


_KNOWN = {"schema", "recordings", "baseline", "findings", "excluded", "untestable", "extended", "noise_floor", "verdict", "warnings"}


def view(findings: dict[str, Any]) -> View:
    """Read the content of findings.json (schema 1)."""
    baseline, extended = mapping(findings.get("baseline")), mapping(findings.get("extended"))
    return View(
        verdict=text(findings.get("verdict")) or "unknown",
        model=text(baseline.get("model")),
        recordings=tuple(sequence(findings.get("recordings"))),
        findings=tuple(_finding(mapping(f), baseline) for f in sequence(findings.get("findings"))),
        errors=_errors(mapping(baseline.get("rmse")), mapping(extended.get("rmse")), mapping(findings.get("noise_floor"))),
        before=_model_amounts(baseline.get("parameters")),
        after=_model_amounts(extended.get("parameters")),
        excluded=tuple(mapping(e) for e in sequence(findings.get("excluded"))),
        untestable=tuple(mapping(e) for e in sequence(findings.get("untestable"))),
        warnings=tuple(text(w) for w in sequence(findings.get("warnings"))),
        other={k: v for k, v in findings.items() if k not in _KNOWN},
    )


def mapping(thing: Any) -> dict[str, Any]:
    """`thing` where it is a mapping, else an empty one."""
    return thing if isinstance(thing, dict) else {}


def sequence(thing: Any) -> list[Any]:
    """`thing` as a list; a single value is a list of one."""
    return list(thing) if isinstance(thing, (list, tuple)) else [] if thing is None else [thing]


def text(thing: Any) -> str:
    """`thing` as a line of text: mappings become `key: value` pairs, numbers have three digits."""
    if isinstance(thing, bool):
        return "yes" if thing else "no"
    if isinstance(thing, float):
        return plain(thing)
    if isinstance(thing, dict):
        return "; ".join(f"{spoken(k)}: {text(v)}" for k, v in thing.items())
    if isinstance(thing, (list, tuple)):
        return ", ".join(text(v) for v in thing)
    return "" if thing is None else str(thing)


def parameter_label(name: str) -> str:
    """Words for `k1` or `share_2`."""
    if name.startswith("share_"):
        return f"share of the sensed force that reaches taxel {name[6:]}"
    return parameter_words(name) or spoken(name)


def _model_amounts(entries: Any) -> tuple[Amount, ...]:
    """Parameters of a model: its own (`k1`), and those of its effects (`stress_relaxation.skin.tau`)."""
    entries = {str(name): entry for name, entry in mapping(entries).items()}
    parts: dict[tuple[str, str], list[str]] = {}
    for name in entries:
        if name.count(".") == 2:
            cause, where, short = name.split(".")
            parts.setdefault((cause, where), []).append(short)
    words = {
        f"{cause}.{where}.{short}": f"{cause_at(cause, where)}: {effect_words(cause, where, tuple(names)).get(short) or spoken(short)}"
        for (cause, where), names in parts.items()
        for short in names
    }
    return tuple(_amount(name, entry, words.get(name) or parameter_label(name)) for name, entry in entries.items())


def _amount(name: str, entry: Any, words: str) -> Amount:
    entry = entry if isinstance(entry, dict) else {"value": entry}
    return Amount(name, words, finite(entry.get("value")), text(entry.get("unit")), finite(entry.get("std")))


def _finding(f: dict[str, Any], baseline: dict[str, Any]) -> Finding:
    cause, where = text(f.get("cause")), text(f.get("where"))
    channels = tuple(text(c) for c in sequence(f.get("channels")))

    sizes = {str(name).rpartition(".")[2]: entry for name, entry in mapping(f.get("parameters")).items()}
    words = effect_words(cause, where, tuple(sizes))
    return Finding(
        cause,
        where,
        channels,
        tuple(_amount(name, entry, words.get(name) or spoken(name)) for name, entry in sizes.items()),
        tuple(mapping(f.get("evidence")).items()),
        _gain(mapping(f.get("gain")), channels, baseline),
        tuple(_alternative(a) for a in sequence(f.get("alternatives"))),
        text(f.get("separating_experiment")),
    )


def _gain(g: dict[str, Any], channels: tuple[str, ...], baseline: dict[str, Any]) -> Gain:
    low, high = (*map(finite, sequence(g.get("ci95"))), None, None)[:2]
    channel = text(g.get("channel")) or (channels[0] if channels else "")
    unit = text(g.get("unit")) or text(mapping(mapping(baseline.get("rmse")).get(channel)).get("unit")) or "N"
    return Gain(
        finite(g.get("held_out_rmse_before")), finite(g.get("held_out_rmse_after")), low, high, channel, unit, text(g.get("held_out"))
    )


def _alternative(a: Any) -> tuple[str, str, str]:
    if not isinstance(a, dict):
        return text(a), "", ""
    return text(a.get("cause")), text(a.get("where")), text({k: v for k, v in a.items() if k not in ("cause", "where")})


def _errors(before: dict, after: dict, floor: dict) -> tuple[ChannelError, ...]:
    return tuple(_error(c, mapping(before.get(c)), mapping(after.get(c)), floor.get(c)) for c in dict.fromkeys([*before, *after]))


def _error(channel: str, before: dict, after: dict, floor: Any) -> ChannelError:
    if isinstance(floor, dict):
        floor = next((v for v in (finite(floor.get(k)) for k in ("value", "rmse", "std", "held_out")) if v is not None), None)
    pairs = [(finite(before.get(k)), finite(after.get(k))) for k in ("train", "held_out")]
    return ChannelError(channel, text(before.get("unit") or after.get("unit")) or "N", *pairs, finite(floor))
