"""Campaigns of hide and seek on simulated recordings: hide, diagnose, compare with the truth and with an oracle that knows it.

Every seed is a new specimen and new noise, with several sessions of one battery, the last held out. Results are kept as JSON lines, one
per case, so that an interrupted campaign continues where it stopped.
"""

import json
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from skin_ident.criticism.diagnose import diagnose
from skin_ident.hiding.errors import HidingError
from skin_ident.hiding.hide import Hidden, hide
from skin_ident.hiding.oracle import oracle_errors
from skin_ident.hiding.simulated_rig import SimulatedRig, varied
from skin_ident.recordings.recording import Recording
from skin_models.materials import material
from skin_motion_profiles.battery_file import read_battery
from skin_motion_profiles.catalogue import entry_from_dict

NULL = "null"
SESSIONS = 3  # per case
SKIN = "silicone_4mm"
SHARES = (1.0, 0.35, 0.1, 0.05)  # of the force that each taxel feels; the first is under the plunger
UNPLAYED = {"skipped", "failed"}  # a result with one of these holds the reason, and nothing else but its case
FOUND = {"where", "form", "imitated", "named", "alternatives", "verdict", "over_oracle", "seconds_per_session"}  # in every other result


@dataclass(frozen=True)
class Case:
    """What is hidden in which recordings; equal cases give equal results. `cause` is NULL where nothing is hidden; `size` is in units of
    the noise."""

    cause: str
    size: float
    seed: int
    protocol: str = "full"
    taxels: int = 1


def cases(causes: Iterable[str], sizes: Iterable[float], seeds: int, protocol: str, taxels: int) -> list[Case]:
    """Every combination of cause, size and seed; NULL (nothing hidden) is taken once per seed, with size 0. Cases are ordered by seed, so
    that a campaign that is stopped has seen a little of everything."""
    sizes = list(sizes)
    pairs = [(seed, cause, size) for seed, cause in product(range(seeds), causes) for size in (sizes if cause != NULL else [0.0])]
    return [Case(cause, size, seed, protocol, taxels) for seed, cause, size in pairs]


def recordings(case: Case) -> list[Recording]:
    """The recordings before anything is hidden in them. Raises `ProfileError` for a battery that does not exist or is no single motion."""
    specimen = varied(material(SKIN).model, case.seed)
    specimen = replace(specimen, shares=SHARES[: case.taxels])
    takes_seed = "seed" in (read_battery(case.protocol).get("arguments") or {})
    seeds = [SESSIONS * case.seed + i for i in range(SESSIONS)]
    batteries = [entry_from_dict({"battery": case.protocol, **({"seed": s} if takes_seed else {})}) for s in seeds]
    return [SimulatedRig().record(specimen, b, s, f"session_{i}") for i, (b, s) in enumerate(zip(batteries, seeds, strict=True), 1)]


def result(case: Case) -> dict[str, Any]:
    """The result of one case, as written to the result file. Errors are part of it and are not raised."""
    try:
        plain = recordings(case)
        changed, hidden = (plain, None) if case.cause == NULL else hide(plain, case.cause, size=case.size, seed=case.seed)
        return {**asdict(case), **_sought(changed, hidden, case.taxels)}
    except HidingError as error:
        return {**asdict(case), "skipped": str(error)}
    except Exception as error:  # a campaign of hours must survive an error, and report it
        return {**asdict(case), "failed": f"{type(error).__name__}: {' '.join(str(error).split())}"}


def _sought(changed: list[Recording], hidden: Hidden | None, taxels: int) -> dict[str, Any]:
    started = time.perf_counter()
    findings = diagnose(changed[:-1], changed[-1:]).findings
    seconds = (time.perf_counter() - started) / len(changed)
    return {
        "where": "" if hidden is None else _plain(hidden.where, taxels),
        "form": "" if hidden is None else hidden.effect.form,
        "imitated": hidden is not None and hidden.imitated,
        "named": [(f["cause"], _plain(f["where"], taxels)) for f in findings["findings"]],
        "alternatives": [(a["cause"], _plain(a["where"], taxels)) for f in findings["findings"] for a in f["alternatives"]],
        "verdict": findings["verdict"],
        "over_oracle": _over_oracle(findings, changed, hidden),
        "seconds_per_session": seconds,
    }


def _plain(where: str, taxels: int) -> str:
    """The place without the taxel's number where there is only one taxel."""
    return "taxel" if taxels == 1 and where.startswith("taxel") else where


def _over_oracle(findings: dict[str, Any], changed: list[Recording], hidden: Hidden | None) -> float | None:
    """Held-out error of the extended model over the oracle's, in the channel where the ratio is largest; None where there is no oracle."""
    errors = oracle_errors(changed[:-1], changed[-1:], hidden)
    own = {channel: e["held_out"] for channel, e in findings["extended"]["rmse"].items()}
    return None if errors is None else max(own[channel] / error for channel, error in errors.items())


def kept(file: Path) -> Iterator[dict[str, Any]]:
    """The results of a campaign so far; lines that were cut short by an interruption, or are no results, are left out."""
    if not file.exists():
        return
    for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            entry = json.loads(line)
            hash(key(entry))  # the case must be hashable: results are looked up by it
        except (ValueError, KeyError, TypeError):
            continue
        if entry.keys() & UNPLAYED or entry.keys() >= FOUND:
            yield entry


def keep(entry: dict[str, Any], file: Path) -> None:
    """Append a result to the file, on a new line even where the last line was cut short."""
    cut = file.exists() and file.read_bytes()[-1:] not in (b"", b"\n")
    with file.open("a", encoding="utf-8") as lines:
        lines.write("\n" * cut + json.dumps(entry) + "\n")


def key(entry: dict[str, Any]) -> Case:
    """The case that a result belongs to."""
    return Case(**{name: entry[name] for name in ("cause", "size", "seed", "protocol", "taxels")})
