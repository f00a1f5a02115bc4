"""How often a finding is right: the tables and the figure of doc/reliability.md and doc/worlds.md, from the counts in doc/reliability.csv.

    bench_reliability.py [--write]        (./skin bench reliability: as it stands)

It prints the pooled tables; --write puts all tables into the pages, and draws the figure.
"""

import csv
import re
import sys
from collections.abc import Iterable
from datetime import date
from pathlib import Path

from reliability_counts import DOC, HIDDEN, NOTHING, WORDS, Pool, Row, interval, latest, pool, pools, read

from skin_ident.criticism.vocabulary import BY_NAME

LAST = 4  # strangers' worlds that stand for the present code
MARK = re.compile(r"(<!-- table: (.+?) -->\n).*?(<!-- end of table -->)", re.S)


def share(k: int, n: int) -> str:
    """A share in percent, with its interval."""
    low, high = interval(k, n)
    digits = 1 if k < 0.05 * n or k > 0.95 * n else 0
    ends = [f"{100 * x:.{1 if min(x, 1 - x) < 0.05 and 0 < x < 1 else 0}f}" for x in (low, high)]
    return f"{100 * k / n:.{digits if 0 < k < n else 0}f} % ({' to '.join(ends)})"


def table(head: Iterable[str], body: Iterable[Iterable[object]]) -> str:
    """A markdown table; zeros are left blank."""
    first = list(head)
    lines = [first, ["---"] * len(first), *body]
    return "\n".join("| " + " | ".join("" if c in (0, None) else str(c) for c in line) + " |" for line in lines) + "\n"


def summary(rows: list[Row]) -> str:
    """One line a kind: the table of the first screen."""
    lines: list[tuple[str, tuple[str, ...], bool | None]] = [
        ("nothing hidden, our own world", ("null",), True),
        ("nothing hidden, strangers' worlds", ("null",), False),
        ("nothing hidden, poor protocols", ("null_poor",), None),
        ("nothing hidden, drawn to be loud", ("null_loud",), None),
        ("one effect, half of the noise's size", ("half",), None),
        ("one effect of the noise's size", ("noise",), None),
        ("one effect, 1 to 4 times the noise", ("above",), None),
        ("one effect, 3 to 6 times the noise", ("several",), None),
        ("two effects at once", ("pair",), None),
        ("one effect, poor protocols", ("poor",), None),
        ("4 to 12 sessions over days", ("sessions", "pair_sessions"), None),
        ("what a given model or twin has wrong", ("given",), None),
        ("other kinds of data", ("other", "pair_other"), None),
        ("closed loop", ("loop", "pair_loop"), None),
    ]
    head = ("what", "cases", "right", "rival", "untestable, in doubt", "untold", "wrong", "extra names", "right answer (95 %)")
    body = []
    for what, kinds, own in lines:
        p = Pool([r for kind in kinds for r in pool(rows, kind, own).rows])
        counts = (p.cases, p.right, p.rival, p.untestable, p.untold, p.wrong + p.unstated)
        body.append((what, *counts, "" if kinds[0] in NOTHING else p.extra, share(p.answered, p.cases)))
    return table(head, body)


def nothing(rows: list[Row]) -> str:
    """Sound records."""
    head = ("nothing hidden", "by", "records", "silent", "only *unexplained*", "something named", "told something (95 %)")
    body = []
    for what, by, p in pools(rows, NOTHING):
        body.append((what, by, p.cases, p.right, p.untold, p.wrong + p.unstated, share(p.cases - p.right, p.cases)))
    return table(head, body)


def hidden(rows: list[Row]) -> str:
    """Records with effects."""
    words = ("right", "rival", "untestable, in doubt", "untold", "wrong")
    head = ("hidden", "by", "effects", *words, "extra names, in records", "named (95 %)", "right answer (95 %)", "worst to best run")
    body = []
    for what, by, p in pools(rows, HIDDEN):
        extra = f"{p.extra} in {p.records}"
        counts = (p.cases, *(getattr(p, w) for w in WORDS[:5]))
        body.append((what, by, *counts, extra, share(p.named, p.cases), share(p.answered, p.cases), p.span()))
    return table(head, body)


def verdict(k: int, n: int, target: float, at_most: bool) -> str:
    """Say whether a share keeps a target, and whether its interval leaves that open."""
    low, high = interval(k, n)
    kept = k / n <= target if at_most else k / n >= target
    sure = (high <= target or low > target) if at_most else (low >= target or high < target)
    return (("met" if kept else "**missed**") if sure else ("met" if kept else "missed") + ", within error") if n else ""


def targets(rows: list[Row]) -> str:
    """What the project had set itself, and what came of it: in all, and in the strangers' worlds that were counted last."""
    last = latest(rows, LAST)

    def line(question: str, kind: str, of, target: float | None, at_most: bool = False) -> tuple[str, ...]:
        cells = []
        for p in (pool(rows, kind, own=True), pool(rows, kind, own=False), pool(last, kind)):
            k, n = of(p)
            if not n:
                cells.append("none counted")
                continue
            cells.append(f"{k} of {n}, {share(k, n)}" + (f": {verdict(k, n, target, at_most)}" if target else ""))
        said = "" if target is None else f"at {'most' if at_most else 'least'} {100 * target:.0f} %"
        return question, said, *cells

    def answered(p: Pool) -> tuple[int, int]:
        return p.answered, p.cases

    body = [
        line("nothing hidden: something is named all the same", "null", lambda p: (p.wrong + p.unstated, p.cases), 0.01, at_most=True),
        line("one effect of the noise's size: right answer", "noise", answered, 0.95),
        line("one effect of half that size: right answer", "half", answered, 0.90),
        line("one effect, poor protocol: right answer", "poor", answered, 0.90),
        line("two effects: both are named, by record", "pair", lambda p: p.told_of("both"), 0.90),
        line("the same: both have a right answer", "pair", lambda p: p.told_of("both_answered"), None),
        line("two effects: extra names, per record", "pair", lambda p: (p.extra, p.records), 0.05, at_most=True),
    ]
    span = f"{last[0].text['world']} to {last[-1].text['world']}"
    head = ("question", "target", "our own world", "strangers' worlds, first run", f"the last of these, {span}")
    return table(head, body)


def causes() -> str:
    """Per cause: what became of it where it was hidden, and how often its name was true where it was told."""
    sums: dict[str, dict[str, int]] = {}
    with (DOC / "reliability_causes.csv").open(encoding="utf-8", newline="") as lines:
        for line, text in enumerate(csv.DictReader(lines), start=2):
            counts = {k: int(v) for k, v in text.items() if k not in ("from", "cause")}
            if sum(counts[w] for w in WORDS[:5]) != counts["hidden"] or counts["false"] > counts["told"]:
                raise SystemExit(f"reliability_causes.csv, line {line} does not add up: {text}")
            of = sums.setdefault(text["cause"], dict.fromkeys(counts, 0))
            of.update({k: of[k] + v for k, v in counts.items()})
    sums["all"] = {k: sum(c[k] for c in sums.values()) for k in next(iter(sums.values()))}
    head = ("cause", "hidden", "named", "untestable, in doubt", "untold", "wrong", "named, %", "told", "told falsely", "what shows it")
    body = []
    for cause, c in sorted(sums.items(), key=lambda item: (item[0] == "all", -_named(item[1]) / item[1]["hidden"], item[0])):
        kept = (c["hidden"], _named(c), c["untestable"], c["untold"], c["wrong"], f"{100 * _named(c) / c['hidden']:.0f}")
        shown = BY_NAME[cause].needs if cause in BY_NAME else ""
        body.append((f"`{cause}`" if cause in BY_NAME else cause, *kept, c["told"], c["false"], shown))
    return table(head, body)


def _named(counts: dict[str, int]) -> int:
    return counts["right"] + counts["rival"]


def world(rows: list[Row], name: str) -> str:
    """All rows of a world, as they were counted."""
    of = [r for r in rows if r.text["world"] == name]
    if not of:
        raise SystemExit(f"reliability.csv has no row of {name}")
    columns: dict[str, list[object]] = {"what": [r.text["what"] for r in of]}
    if name == "own":
        columns["counted"] = [f"{date.fromisoformat(r.text['counted']):%-d %b}" for r in of]
    columns["cases"] = [_cases(r) for r in of]
    for word in WORDS:
        columns[word] = [r.number[word] for r in of]
    columns["untold"] = [_untold(r) for r in of]
    columns["extra names"] = [r.number["extra"] for r in of]
    columns["remarks"] = [r.text["remark"] for r in of]
    columns["after what it taught"] = [r.text["after"] for r in of]
    columns["pooled"] = ["" if r.text["pooled"] == "earlier" else r.text["pooled"] for r in of]
    kept = {head: cells for head, cells in columns.items() if any(cells)}
    return table(kept, zip(*kept.values(), strict=True))


def _cases(row: Row) -> str:
    of, records = row.number["cases"], row.text["records"]
    two = row.text["kind"].startswith("pair")
    return f"{of} effects" + (f" in {records}" if records else "") if two else str(of) + (f" in {records}" if records != str(of) else "")


def _untold(row: Row) -> object:
    n, riddles = row.number["untold"], row.number["unexplained"]
    if riddles:
        return f"{n} *unexplained*" if n == riddles else f"{n}, {riddles} *unexplained*"
    return n


def made(rows: list[Row], name: str) -> str:
    """The table of a mark in a page."""
    if name == "causes":
        return causes()
    simple = {"summary": summary, "targets": targets, "nothing": nothing, "hidden": hidden}
    return simple[name](rows) if name in simple else world(rows, name.removeprefix("world "))


def filled(page: str, rows: list[Row]) -> str:
    """A page with all of its tables as the counts have them."""
    return MARK.sub(lambda m: m[1] + made(rows, m[2]) + m[3], page)


PAGES = ("reliability.md", "worlds.md")
LOOKS = {
    "right": ("right", "#1b7f4d"),
    "rival": ("right beside a rival, or among the rivals", "#8fd0a5"),
    "untestable": ("rightly untestable or in doubt", "#f0c648"),
    "untold": ("untold, or only unexplained", "#b9bec7"),
    "wrong": ("wrong", "#c62f2f"),
    "unstated": ("told something, which was not kept", "#e79a8f"),
}


def draw(rows: list[Row], file: Path) -> None:
    """Bars of all pools."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    groups = (("nothing hidden (green: silent)", NOTHING), ("something hidden", HIDDEN))
    figure, axes = plt.subplots(
        2, 1, figsize=(9.6, 8.6), layout="constrained", height_ratios=[len(list(pools(rows, k))) + 1 for _, k in groups]
    )
    for ax, (title, kinds) in zip(axes, groups, strict=True):
        bars = list(pools(rows, kinds))
        for y, (_, _, p) in enumerate(bars):
            left = 0.0
            for word, (_, colour) in LOOKS.items():
                width = 100 * getattr(p, word) / p.cases
                ax.barh(y, width, left=left, color=colour, edgecolor="white", linewidth=0.6, height=0.78)
                if width >= 3.4:
                    ink = "white" if word in ("right", "wrong") else "black"
                    ax.text(left + width / 2, y, f"{getattr(p, word)}", ha="center", va="center", fontsize=8, color=ink)
                left += width
            extra = f"   +{p.extra} extra" if kinds is HIDDEN and p.extra else ""
            ax.text(101, y, f"{p.cases}{extra}", va="center", fontsize=8.5)
        ax.set(xlim=(0, 100), ylim=(len(bars) - 0.4, -0.6), yticks=range(len(bars)))
        ax.set_yticklabels([f"{what}, {by}" for what, by, _ in bars], fontsize=9)
        ax.set_title(title, loc="left", fontsize=10, fontweight="bold")
        ax.spines[["top", "right", "left"]].set_visible(False)
        ax.tick_params(axis="y", length=0)
        ax.set_xlabel("% of the records" if kinds is NOTHING else "% of the effects; at the right: how many, and extra names", fontsize=9)
    boxes = [plt.Rectangle((0, 0), 1, 1, color=colour) for _, colour in LOOKS.values()]
    figure.legend(boxes, [label for label, _ in LOOKS.values()], loc="outside upper center", ncols=3, fontsize=9, frameon=False)
    figure.savefig(file, dpi=100)


def main() -> None:
    """Print the pooled tables; bring the pages up to date where that is asked for."""
    rows = read()
    print("\n".join((summary(rows), targets(rows), nothing(rows), hidden(rows))))
    if "--write" in sys.argv[1:]:
        for page in (DOC / name for name in PAGES):
            page.write_text(filled(page.read_text(encoding="utf-8"), rows), encoding="utf-8")
        draw(rows, DOC / "reliability.png")


if __name__ == "__main__":
    main()
