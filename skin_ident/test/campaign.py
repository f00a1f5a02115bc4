"""python campaign.py KIND: hides effects by the hundred in the world's recordings and counts what the diagnosis makes of them.

KIND is `null`, `poor_null`, `single`, `pair` or `poor`. One line a case; at the end the rates with their counts, extra names, the held-out
error over that of an oracle that knows the noise-free signal, and the time. A case is right when the hidden cause is named at its place;
`admitted` when it is among the alternatives of a finding, or the name is one of the rivals that carry the same equations; `untestable` when
the cause is listed as such and nothing else is named than what is hidden; `bounded` when nothing else is named and the report bounds it no
closer than declared calibrations and widths allow; `too small` when it is not found and the world could not make it nearly as
large as was asked, or another hidden effect leaves next to nothing of it, as a dead taxel does.
"""

import argparse
import hashlib
import os
import pickle
import tempfile
import time
import warnings
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")

import numpy as np
from world import make_sessions, write_case
from world.blind import POOR
from world.hidden import NEEDS_ARRAY, PLACES, Hide
from world.lookalikes import lookalikes

from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.sessions.parting import meeting
from skin_ident.recordings.load import load
from skin_models.signals import motion

NOT_EFFECTS = ("noise", "data_error", "parameters", "unknown")
LEAST = 0.3  # of the size asked for, below which nobody could have found it


@dataclass(frozen=True)
class Case:
    """What to hide, and the arguments of `make_sessions`."""

    hides: tuple[Hide, ...]
    setting: dict


@dataclass(frozen=True)
class Judged:
    """What came of it: a word for each hidden cause, names that were not hidden, error over the oracle's, seconds."""

    words: tuple[str, ...]
    extra: tuple[str, ...]
    ratio: float
    seconds: float
    said: str


def plan(kind: str, index: int, seed: int, size: float, causes: list[str], **setting_of_all) -> Case:
    """Case `index` of a campaign, with what the setting of all cases is to have; equal arguments give equal cases."""
    rng = np.random.default_rng([seed, index])
    setting = {"seed": int(rng.integers(2**31)), "protocol": str(rng.choice(POOR)) if kind.startswith("poor") else "full"}
    setting["n_taxels"] = int(rng.choice([1, 1, 2, 3]))
    setting["encoder_step_um"] = float(rng.choice([1.0, 1.0, 5.0, 10.0, 20.0])) if kind.endswith("null") else 1.0
    setting["encoder_noise_um"] = float(np.random.default_rng([seed, index, 1]).choice([0.0, 0.0, 0.5, 1.5, 4.0]))
    setting["between"] = float(np.random.default_rng([seed, index, 2]).choice([0.0, 0.0, 0.01]))  # of the skin, from session to session
    count = {"null": 0, "poor_null": 0, "pair": 2}.get(kind, 1)
    names = [causes[index % len(causes)]] if count == 1 else list(rng.choice(causes, count, replace=False))
    hides = tuple(Hide(str(n), str(rng.choice(PLACES[str(n)])), None, size) for n in names)
    if any(h.cause in NEEDS_ARRAY or h.form == "copied_column" for h in hides):
        setting["n_taxels"] = max(3, setting["n_taxels"])
    return Case(hides, setting | setting_of_all)


def made(case: Case, keep: Path | None):
    """Sessions, truth and look-alikes of a case; kept as a file where a folder is given: making them costs more than a diagnosis."""
    kept = keep and keep / f"{hashlib.sha1(repr(case).encode()).hexdigest()}.pickle"
    if kept and kept.exists():
        return pickle.loads(kept.read_bytes())
    sessions, truth = make_sessions(list(case.hides), **case.setting)
    alike = lookalikes(truth) if truth.hidden and truth.protocol != "full" else []
    truth = replace(truth, rig=None, hidden=[replace(h, effect=None) for h in truth.hidden])
    if kept:
        keep.mkdir(parents=True, exist_ok=True)
        kept.write_bytes(pickle.dumps((sessions, truth, alike)))
    return sessions, truth, alike


def run(case: Case, keep: Path | None = None) -> tuple[Judged, object]:
    """Make, write, read back, diagnose with the last session held out, and judge."""
    sessions, truth, alike = made(case, keep)
    with tempfile.TemporaryDirectory() as folder:
        write_case(sessions, folder)
        recordings = load(folder)
    started = time.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        outcome = diagnose(recordings[:-1], recordings[-1:])
    seconds = time.process_time() - started
    return judge(outcome, truth, alike, seconds), outcome


def judge(outcome, truth, alike: list, seconds: float) -> Judged:
    """Hold the findings against the truth."""
    findings = outcome.findings
    words = tuple(_word(h, findings, alike, _meanings(truth.hidden)) for h in truth.hidden)
    hidden = _meanings(truth.hidden)
    extra = tuple(f"{f['cause']}/{f['where']}" for f in findings["findings"] if not _meant(f, hidden))
    said = "; ".join(_line(f) for f in findings["findings"]) or findings["verdict"]
    return Judged(words, extra, _over_oracle(outcome, truth), seconds, said)


def _meanings(hidden) -> set[str]:
    """Everything that a finding may be called."""
    return {c for h in hidden for c in (h.cause, *h.rivals)}


def _word(hidden, findings, alike: list, meant: set[str]) -> str:
    here = [f for f in findings["findings"] if f["cause"] == hidden.cause]
    if any(_same_place(f["where"], hidden.where) for f in here):
        return "right"
    among = [a for f in findings["findings"] for a in f["alternatives"]]
    if any(a["cause"] == hidden.cause and _same_place(a["where"], hidden.where) for a in among):
        return "admitted"
    if here:
        return "elsewhere"
    if any(f["cause"] in hidden.rivals for f in findings["findings"]):
        return "admitted"
    if findings["findings"] and _passes_for(findings, alike):
        return "admitted"
    strange = [f for f in findings["findings"] if not _meant(f, meant)]
    if not strange and any(u["cause"] == hidden.cause and _about(u, hidden) for u in findings["untestable"]):
        return "untestable"
    if strange:
        return "wrong"
    if any(e["cause"] == hidden.cause and e.get("limited_by") and _same_place(e["where"], hidden.where) for e in findings["excluded"]):
        return "bounded"
    return "missed" if min(np.max(hidden.visible), hidden.beside) > LEAST * hidden.size else "too small"


def _about(reason, hidden) -> bool:
    """Whether a reason speaks of what is hidden: one with a place speaks of a constant form there, or of what was seen and is in
    doubt, or such as good hardware does."""
    if "where" not in reason:
        return True
    of_this = reason.get("in_doubt") or reason.get("hardware")
    return (hidden.form == "static" or of_this) and _same_place(reason["where"], hidden.where)


def _passes_for(findings, alike: list) -> bool:
    """Whether what is named leaves the same trace as the truth under a poor protocol."""
    return all(any(f["cause"] == cause and _same_place(f["where"], where) for cause, where, *_ in alike) for f in findings["findings"])


def _same_place(one: str, other: str) -> bool:
    alike = "taxel" in (one, other) and one.startswith("taxel") and other.startswith("taxel")  # the lone taxel has no number
    return one == other or alike


def _meant(finding, hidden: set[str]) -> bool:
    return finding["cause"] in hidden or any(a["cause"] in hidden for a in finding["alternatives"])


def _line(f) -> str:
    g = f["gain"]
    rivals = "|".join(f"{a['cause']}/{a['where']}" for a in f["alternatives"])
    return (
        f"{f['cause']}/{f['where']}"
        + (f" or {rivals}" if rivals else "")
        + f" {_n(g['held_out_rmse_before'])}>{_n(g['held_out_rmse_after'])}"
    )


def _n(value) -> str:
    return "-" if value is None else f"{value:.3f}"


def _over_oracle(outcome, truth) -> float:
    """Held-out error of the extended model over that of the noise-free signal, away from touchdowns, in the worst channel; nan where
    samples do not line up."""
    held = [t for t in outcome.traces if t.held_out]
    if not held or held[-1].measured.shape[1] != truth.signals[-1].force.size:
        return float("nan")
    t, signal = held[-1], truth.signals[-1]
    clean = np.vstack([signal.force, signal.taxels.T])[-len(t.channels) :]
    away = ~meeting(motion(t.t, t.depth, t.speed), outcome.model.dispersion)
    error, floor = (np.sqrt(np.mean((t.measured - y)[:, away] ** 2, axis=1)) for y in (t.extended, clean))
    return float(np.max(error / np.maximum(floor, 1e-12)))


def main(arguments: list[str] | None = None) -> None:
    """Command line: KIND [--size 1] [--count 54] [--seed 0] [--first 0] [--causes a,b] [--sessions N] [--between X] [--keep FOLDER]."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kind", choices=("null", "poor_null", "single", "pair", "poor"))
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--count", type=int, default=54)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--causes", default="")
    parser.add_argument("--sessions", dest="n_sessions", type=int, help="in a case, the last one held out; without it three")
    parser.add_argument("--between", type=float, help="change of the skin from session to session; without it 0 or 0.01")
    parser.add_argument("--keep", type=Path, help="folder for the cases, to run them again after a change")
    o = parser.parse_args(arguments)
    causes = o.causes.split(",") if o.causes else [c for c in PLACES if c not in NOT_EFFECTS]
    of_all = {name: value for name, value in vars(o).items() if name in ("n_sessions", "between") and value is not None}
    judged = []
    for index in range(o.first, o.first + o.count):
        case = plan(o.kind, index, o.seed, o.size, causes, **of_all)
        j, outcome = run(case, o.keep)
        judged.append((case, j, outcome.findings["verdict"]))
        what = "; ".join(f"{h.cause}/{h.where}/{h.form}" for h in _completed(case)) or "nothing"
        print(f"{index:4d} {'+'.join(j.words) or '-':10s} {what} {_short(case)} -> {j.said}  x{j.ratio:.2f} {j.seconds:.1f} s", flush=True)
    report(judged)


def _completed(case: Case):
    from world.hidden import complete

    return [complete(h, np.random.default_rng([case.setting["seed"], 7, i])) for i, h in enumerate(case.hides)]


def _short(case: Case) -> str:
    s = case.setting
    return f"[{s['protocol']} {s['n_taxels']} taxels]" if s["protocol"] != "full" else f"[{s['n_taxels']}]"


def report(judged) -> None:
    """The rates with their counts."""
    words = Counter(w for _, j, _ in judged for w in j.words)
    extra = [e for _, j, _ in judged for e in j.extra]
    loud = sum(v != "nothing_wrong" for _, _, v in judged)
    print(f"\n{len(judged)} cases: " + ", ".join(f"{n} {w}" for w, n in words.most_common()))
    print(f"cases with an extra name: {sum(bool(j.extra) for _, j, _ in judged)} ({', '.join(extra)}); verdict not nothing_wrong: {loud}")
    ratios = np.array([j.ratio for _, j, _ in judged])
    ratios = ratios[np.isfinite(ratios)]
    if ratios.size:
        middle, most = np.median(ratios), np.quantile(ratios, 0.9)
        print(f"held-out error over the oracle's: median {middle:.3f}, 90 % below {most:.3f} ({ratios.size} cases)")
    print(f"CPU time per diagnosis: median {np.median([j.seconds for _, j, _ in judged]):.1f} s")


if __name__ == "__main__":
    main()
