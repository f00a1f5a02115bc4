"""The results of a campaign: rates with counts and confidence intervals, the confusion matrix, and tables."""

import csv
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import beta

from skin_ident.hiding.campaign import NULL

NOTHING = "nothing"
COLUMNS = ("cause", "where", "form", "size", "seed", "protocol", "taxels", "right", "named", "alternatives", "verdict", "over_oracle")

Result = dict[str, Any]


def interval(hits: int, of: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper-Pearson interval of a rate (C. J. Clopper, E. S. Pearson, Biometrika 26 (1934) 404-413)."""
    low = beta.ppf((1 - level) / 2, hits, of - hits + 1) if hits else 0.0
    high = beta.ppf((1 + level) / 2, hits + 1, of - hits) if hits < of else 1.0
    return float(low), float(high)


def rate(hits: int, of: int) -> str:
    """A rate in words, with its 95 % interval: `19 of 20, 95 % (75.1 to 99.9 %)`."""
    if not of:
        return "none tried"
    low, high = interval(hits, of)
    return f"{hits} of {of}, {100 * hits / of:.0f} % ({100 * low:.1f} to {100 * high:.1f} %)"


def right(r: Result, place: bool = True) -> bool:
    """Whether the truth is named, or given as a rival of what is named; its place must be right too, unless `place` is False. Naming
    nothing is right where nothing was hidden, or where the model's own parameters imitate what was hidden."""
    said = [tuple(n) for n in (*r["named"], *r["alternatives"])]
    if r["cause"] == NULL:
        return not r["named"]
    if unseen(r):
        return True
    return any(c == r["cause"] and (w == r["where"] or not place) for c, w in said)


def unseen(r: Result) -> bool:
    """Whether nothing was named where the model's own parameters imitate what was hidden: no hit and no miss, for nobody could name it."""
    return r["cause"] != NULL and r["imitated"] and not r["named"]


def extra(r: Result) -> list[str]:
    """Named causes that were not hidden. Where the truth is only a rival, the first name is taken to stand for it."""
    names = [n[0] for n in r["named"]]
    return names[1:] if right(r) and r["cause"] not in names else [n for n in names if n != r["cause"]]


def confusion(results: Iterable[Result]) -> tuple[list[str], list[str], np.ndarray]:
    """Hidden causes (R), names (C) and counts (R, C). The name of a case is the hidden cause where it was named, else the first name."""
    pairs = Counter((r["cause"], _name(r)) for r in results)
    causes = sorted({c for c, _ in pairs}, key=lambda c: (c == NULL, c))
    others = sorted({n for _, n in pairs} - set(causes) - {NOTHING})
    names = [*(c for c in causes if c != NULL), *others, NOTHING]
    return causes, names, np.array([[pairs[c, n] for n in names] for c in causes])


def _name(r: Result) -> str:
    names = [n[0] for n in r["named"]]
    return r["cause"] if r["cause"] in names else names[0] if names else NOTHING


def summary(results: list[Result]) -> str:
    """The summary of a campaign as text: confusion, rates, errors over the oracle's, and cases that were skipped or failed."""
    done = [r for r in results if "verdict" in r]
    return "\n".join([*_matrix(done), "", *_rates(done), *_prices(done), *_left_out(results)])


def _matrix(done: list[Result]) -> Iterator[str]:
    causes, names, counts = confusion(done)
    yield "hidden, and what was named:"
    for cause, row in zip(causes, counts, strict=True):
        said = sorted(((n, name) for n, name in zip(row, names, strict=True) if n), reverse=True)
        yield f"  {cause:<20} " + ", ".join(f"{name} {n}" for n, name in said)


def _rates(done: list[Result]) -> Iterator[str]:
    nulls = [r for r in done if r["cause"] == NULL]
    yield f"false alarms with nothing hidden: {rate(sum(not right(r) for r in nulls), len(nulls))}"
    for size in sorted({r["size"] for r in done if r["cause"] != NULL}):
        mine = [r for r in done if r["size"] == size and r["cause"] != NULL]
        told = [r for r in mine if not unseen(r)]
        yield f"size {size:g}: cause right {rate(sum(right(r, False) for r in told), len(told))}"
        yield f"size {size:g}: cause and place right {rate(sum(map(right, told)), len(told))}"
        if len(told) < len(mine):
            apart = "in neither rate, because the fitted model imitates what was hidden, and nothing was named"
            yield f"size {size:g}: {apart}: {len(mine) - len(told)}"
        yield f"size {size:g}: extra names {rate(sum(bool(extra(r)) for r in mine), len(mine))}"


def _prices(done: list[Result]) -> Iterator[str]:
    ratios = [r["over_oracle"] for r in done if r["over_oracle"] is not None]
    if ratios:
        middle, most = np.percentile(ratios, [50, 95])
        yield f"held-out error over the oracle's: median {middle:.3f}, 95 % below {most:.3f} ({len(ratios)} cases)"
    if done:
        yield f"time per session: median {np.median([r['seconds_per_session'] for r in done]):.2f} s"


def _left_out(results: list[Result]) -> Iterator[str]:
    for word in ("skipped", "failed"):
        said = Counter(r[word] for r in results if word in r)
        yield from (f"{word} {n}: {sentence}" for sentence, n in said.items())


def write_tables(results: list[Result], folder: Path) -> None:
    """Write cases.csv, a row per case (`right` is empty where nobody could name what was hidden, see `unseen`), and confusion.csv."""
    done = [r for r in results if "verdict" in r]
    _csv(folder / "cases.csv", COLUMNS, ([_cell(r | {"right": "" if unseen(r) else right(r)}, name) for name in COLUMNS] for r in done))
    causes, names, counts = confusion(done)
    _csv(folder / "confusion.csv", ("hidden", *names), ([c, *row] for c, row in zip(causes, counts.tolist(), strict=True)))


def _cell(r: Result, name: str) -> Any:
    value = r[name]
    return "; ".join(f"{c} in {w}" for c, w in value) if isinstance(value, list) else value


def _csv(path: Path, header: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)
