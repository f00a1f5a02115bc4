"""The counts of doc/reliability.csv, pooled by kind and by who hid the effects.

A row of the CSV is one run of one kind of record in one world. `right` to `unstated` add up to `cases`; `unexplained` is part of `untold`;
of sound records `right` counts those that stayed silent. `pooled` says whether a row counts in the pooled tables: `yes`; `earlier`, by code
that is older by days; `again`, records or worlds that the code had been mended by; `beside`, something else than the diagnosis.
`both` and `both_answered` count records with two effects in which both were named, or both had a right answer, where that was kept.
"""

import csv
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from scipy.stats import beta

DOC = Path(__file__).resolve().parents[1] / "doc"
WORDS = ("right", "rival", "untestable", "untold", "wrong", "unstated")
NUMBERS = (*WORDS, "unexplained", "extra", "cases")

NOTHING = {
    "null": "full protocols",
    "null_poor": "poor protocols",
    "null_loud": "drawn to be loud",
    "null_sessions": "4 to 12 sessions over days",
    "null_other": "other kinds of data",
    "null_given": "a given model or twin that is right",
    "null_loop": "closed loop",
}
HIDDEN = {
    "half": "one, half of the noise's size",
    "noise": "one, of the noise's size",
    "above": "one, 1 to 4 times the noise",
    "several": "one, 3 to 6 times the noise",
    "poor": "one, poor protocols",
    "pair": "two at once",
    "sessions": "one, 4 to 12 sessions over days",
    "pair_sessions": "two, 4 to 12 sessions over days",
    "other": "one, other kinds of data",
    "pair_other": "two, other kinds of data",
    "given": "what a given model or twin has wrong",
    "loop": "one, closed loop",
    "pair_loop": "two, closed loop",
}
BY = {True: "own world", False: "strangers"}


@dataclass(frozen=True)
class Row:
    """One line of the CSV."""

    text: dict[str, str]
    number: dict[str, int]

    @property
    def own(self) -> bool:
        """Whether the world is the project's own."""
        return self.text["world"] in ("own", "loop")


@dataclass(frozen=True)
class Pool:
    """Counts added up."""

    rows: list[Row]

    def __getattr__(self, name: str) -> int:
        """Return the sum of a column."""
        return sum(r.number[name] for r in self.rows)

    def told_of(self, column: str) -> tuple[int, int]:
        """Return a column that only some rows have, and the records of these rows."""
        kept = [r for r in self.rows if r.text[column]]
        return sum(int(r.text[column]) for r in kept), sum(int(r.text["records"]) for r in kept)

    @property
    def records(self) -> int:
        """Return how many records the effects were hidden in."""
        return sum(int(r.text["records"]) for r in self.rows)

    @property
    def named(self) -> int:
        """Effects that are named, or a rival of a name."""
        return self.right + self.rival

    @property
    def answered(self) -> int:
        """The same, and effects that are rightly said to be untestable or in doubt."""
        return self.named + self.untestable

    def span(self) -> str:
        """Return the lowest and the highest share of right answers among runs of ten effects and more, where there are three."""
        shares = [100 * Pool([r]).answered / r.number["cases"] for r in self.rows if r.number["cases"] >= 10]
        return f"{min(shares):.0f} to {max(shares):.0f} %" if len(shares) > 2 else ""


def read() -> list[Row]:
    """Return all counts; a row that does not add up is an error."""
    rows = []
    with (DOC / "reliability.csv").open(encoding="utf-8", newline="") as lines:
        for line, text in enumerate(csv.DictReader(lines), start=2):
            number = {name: int(text[name] or 0) for name in NUMBERS}
            if sum(number[w] for w in WORDS) != number["cases"] or number["unexplained"] > number["untold"]:
                raise SystemExit(f"reliability.csv, line {line} does not add up: {text}")
            if text["pooled"] == "yes" and text["kind"] not in (*NOTHING, *HIDDEN, "unseen"):
                raise SystemExit(f"reliability.csv, line {line} is of no kind that is pooled: {text['kind']}")
            rows.append(Row(text, number))
    return rows


def pool(rows: Iterable[Row], kind: str, own: bool | None = None, words: tuple[str, ...] = ("yes",)) -> Pool:
    """Return the rows of a kind that count, in one's own world, in strangers', or in both."""
    return Pool([r for r in rows if r.text["kind"] == kind and r.text["pooled"] in words and own in (None, r.own)])


def latest(rows: Iterable[Row], worlds: int) -> list[Row]:
    """Return the rows of the strangers' worlds that were counted last, so many worlds."""
    counted = [r for r in rows if not r.own and r.text["pooled"] == "yes"]
    names = list(dict.fromkeys(r.text["world"] for r in counted))[-worlds:]
    return [r for r in counted if r.text["world"] in names]


def interval(k: int, n: int) -> tuple[float, float]:
    """Clopper and Pearson's 95 % interval of a share."""
    return (float(beta.ppf(0.025, k, n - k + 1)) if k else 0.0, float(beta.ppf(0.975, k + 1, n - k)) if k < n else 1.0)


def pools(rows: list[Row], kinds: dict[str, str]) -> Iterable[tuple[str, str, Pool]]:
    """All pools that hold anything: what they are of, who hid it, the counts."""
    for kind, what in kinds.items():
        for own, by in BY.items():
            if (p := pool(rows, kind, own)).rows:
                yield what, by, p
