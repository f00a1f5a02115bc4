"""The outcome for scans with too few trusted readings to fit anything."""

from skin_ident.criticism.errors import DiagnosisError
from skin_ident.criticism.scan.faults import FEWEST, FEWEST_ROWS, IN_A_ROW, Looked
from skin_ident.criticism.scan.findings import recordings, seen, together
from skin_ident.criticism.scan.limits import NEVER
from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.criticism.vocabulary import CAUSES
from skin_ident.spread_scan import SpreadScan

LEFT = "too little of these scans can be believed"
NEEDED = f"{FEWEST_ROWS} depths with {IN_A_ROW} distances each, and {FEWEST} readings in all, are needed"
NOTHING = {"model": "none: too little can be believed to fit one", "parameters": {}, "rmse": {}}


def unreadable(scans: list[SpreadScan], held: list[SpreadScan], looked: Looked) -> Outcome:
    """The faults of the tables, without model and curves. Causes that were looked for in the tables are excluded, all others untestable.
    Raises `DiagnosisError` where there are too few readings and nothing is wrong with them."""
    if not looked.faults:
        raise DiagnosisError(f"{scans[0].name}: {len(looked.every)} readings are too few to judge; {NEEDED}")
    entries = [seen(f) for f in together(looked.faults)]
    named = {entry["cause"] for entry in entries} | {a["cause"] for entry in entries for a in entry["alternatives"]}
    inspected = [c.name for c in CAUSES if looked.known.get(c.name) == "" and c.name not in named and c.name != "noise"]
    open_causes = [c for c in CAUSES if c.name not in named and c.name not in inspected]
    content = {
        "schema": 1,
        "recordings": recordings([*scans, *held], {s.name for s in held}),
        "baseline": NOTHING,
        "findings": entries,
        "excluded": [{"cause": name, "below": None, "unit": "", "because": "looked for and not seen"} for name in inspected],
        "untestable": [
            {"cause": c.name, "because": NEVER.get(c.name) or looked.known.get(c.name) or LEFT, "needs": c.needs} for c in open_causes
        ],
        "extended": NOTHING,
        "noise_floor": {},
        "systematic_rest": {"fall_of_mean_square": None, "lower_bound": None},
        "verdict": "explained",
        "warnings": [*looked.warnings, f"{LEFT} to judge a simulation: {len(looked.cells)} of {len(looked.every)} readings; {NEEDED}"],
    }
    return Outcome(content)
