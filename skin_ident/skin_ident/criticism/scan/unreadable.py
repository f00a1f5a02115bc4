"""What to say of scans of which too little can be believed to fit anything."""

import numpy as np

from skin_ident.criticism.outcome import Outcome, ScanTrace
from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.faults import Looked, answers
from skin_ident.criticism.scan.findings import CHANNEL, recordings, seen, together
from skin_ident.criticism.scan.limits import NEVER
from skin_ident.criticism.scan.start import plain_start
from skin_ident.criticism.vocabulary import CAUSES
from skin_ident.spread_scan import SpreadScan
from skin_models.model import Model

LEFT = "too little of these scans can be believed"
PLAIN = "linear skin with a Gaussian spread"


def unreadable(scans: list[SpreadScan], held: list[SpreadScan], looked: Looked, model: Model | None) -> Outcome:
    """The faults of the tables, everything else untestable. The plain model is fitted to all cells alike, for the picture alone."""
    e, curves, parameters = _picture(looked, scans)
    model_entry = {"model": PLAIN, "parameters": parameters, "rmse": {CHANNEL: {"train": e, "held_out": None, "unit": "N"}}}
    entries = [seen(f, model_entry) for f in together(looked.faults)]
    named = {entry["cause"] for entry in entries}
    inspected = [c.name for c in CAUSES if looked.known.get(c.name) == "" and c.name not in named and c.name != "noise"]
    content = {
        "schema": 1,
        "recordings": recordings([*scans, *held], {s.name for s in held}),
        "baseline": model_entry,
        "findings": entries,
        "excluded": [{"cause": name, "below": None, "unit": "", "because": "looked for and not seen"} for name in inspected],
        "untestable": [
            {"cause": c.name, "because": NEVER.get(c.name) or looked.known.get(c.name) or LEFT, "needs": c.needs}
            for c in CAUSES if c.name not in named and c.name not in inspected
        ],
        "extended": model_entry,
        "noise_floor": {},
        "systematic_rest": {"fall_of_mean_square": None, "lower_bound": None},
        "verdict": "explained" if entries else "nothing_wrong",
        "warnings": [*looked.warnings, f"{LEFT} to fit anything: {len(looked.cells)} of {len(looked.every)} readings"],
    }  # fmt: skip
    return Outcome(content, None, None, {}, (), curves, ())


def _picture(looked: Looked, scans: list[SpreadScan]) -> tuple[float | None, tuple[ScanTrace, ...], dict]:
    every: Cells = looked.every
    if not answers(every):
        return None, (), {}
    m = plain_start(every)
    predicted = m.predict(every)
    curves = []
    for i, s in enumerate(scans):
        table = np.full(s.force.shape, np.nan)
        table[np.isfinite(s.force)] = predicted[every.scan == i]
        curves.append(ScanTrace(s.name, s.depth, s.distance, s.force, table, table))
    sizes = {"k1": (float(m.k[0] / m.scale.deepest), "N/m"), "width": (m.values["width"], "m")}
    parameters = {name: {"value": value, "unit": unit, "std": None} for name, (value, unit) in sizes.items()}
    return float(np.sqrt(np.mean((every.y - predicted) ** 2))), tuple(curves), parameters
