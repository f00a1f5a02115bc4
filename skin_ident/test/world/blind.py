"""python -m world.blind FOLDER: a mixed set of cases for trials, FOLDER/data for the critic and FOLDER/sealed/answers.json for the judge.

A case's folder holds sessions (`session_0.tsv`, …, the last one meant for holding out) or spread scans, and `rig.yaml`;
some hold a `given_model.json`.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from . import scans
from .hidden import NEEDS_ARRAY, PLACES, Hide
from .lookalikes import energy, lookalikes
from .protocols import BODIES
from .sessions import make_sessions, without
from .tables import write_case, write_rig

KINDS = {"null": 0.22, "single": 0.42, "pair": 0.1, "poor": 0.14, "scan": 0.06, "unknown": 0.03, "columns": 0.03}
RARE = ("unknown", "parameters", "noise", "data_error")
POOR = [name for name in BODIES if name not in ("full", "full_no_free_air")]


def plan(index, seed) -> dict:
    """What case `index` of the set is: kind, what is hidden, and the arguments of `make_sessions`."""
    rng = np.random.default_rng([seed, index])
    kind = str(rng.choice(list(KINDS), p=np.array(list(KINDS.values())) / sum(KINDS.values())))
    setting = {
        "seed": int(rng.integers(2**31)), "protocol": str(rng.choice(POOR)) if kind == "poor" else "full",
        "n_taxels": int(rng.choice([1, 1, 2, 3, 4])), "encoder_step_um": float(rng.choice([1.0, 1.0, 1.0, 5.0, 10.0, 20.0])),
        "between": float(rng.choice([0.0, 0.0, 0.01])),
    }  # fmt: skip
    if kind == "scan":
        cause = rng.choice([None, *scans.CAUSES])
        return {"kind": kind, "hides": [[cause, "taxel" if cause == "quantization" else "skin", None, 1.5]], "setting": setting}
    hides = _draw_hides(rng, kind)
    if any(h.cause in NEEDS_ARRAY or h.form == "copied_column" for h in hides):
        setting["n_taxels"] = max(3, setting["n_taxels"])
    return {"kind": kind, "hides": [[h.cause, h.where, h.form, h.size] for h in hides], "setting": setting}


def _draw_hides(rng, kind):
    if kind == "null":
        return []
    common = [c for c in PLACES if c not in RARE]
    names = {"unknown": ["unknown"], "pair": list(rng.choice(common, 2, replace=False))}.get(kind)
    if names is None:
        names = [str(rng.choice(list(RARE[1:]))) if kind == "single" and rng.random() < 0.12 else str(rng.choice(common))]
    size = float(rng.choice([0.5, 1.0, 2.0])) if kind in ("single", "poor") else 1.5
    return [Hide(str(name), str(rng.choice(PLACES[str(name)])), None, size) for name in names]


def make_case(index, seed, folder) -> dict:
    """Write one case under FOLDER/data and give its answer."""
    what = plan(index, seed)
    data = Path(folder) / "data" / f"case_{index:03d}"
    if what["kind"] == "scan":
        return {**what, **_make_scan_case(what, data)}
    hides = [Hide(*h) for h in what["hides"]]
    sessions, truth = make_sessions(hides, **what["setting"])
    dropped = ()
    if what["kind"] == "columns":
        dropped = (str(np.random.default_rng([seed, index, 1]).choice(["x", "taxels"])),)
        sessions = [without(s, *dropped) for s in sessions]
    write_case(sessions, data)
    if truth.given_model:
        (data / "given_model.json").write_text(json.dumps(truth.given_model))
    return {**what, **_answer(what, truth), "dropped": dropped}


def _answer(what, truth):
    hidden = [{k: v for k, v in vars(h).items() if k != "effect"} for h in truth.hidden]
    answer = {"hidden": hidden, "noise": vars(truth.noise), "noise_rms": truth.noise_rms, "given_model": truth.given_model}
    skin = {k: getattr(truth.skin, k) for k in ("thickness_mm", "k1", "b1", "k2", "b2", "mass", "width")}
    if what["kind"] == "poor":
        answer |= {"energy": energy(truth), "lookalikes": lookalikes(truth)}
    return answer | {"skin": skin}


def _make_scan_case(what, data):
    cause, _, form, size = what["hides"][0]
    made, truth = scans.make_scan(cause, form, size, what["setting"]["seed"])
    for scan in made:
        scans.write_scan(scan, data / f"scan_{scan.direction}.csv")
    write_rig({"taxel_step_n": 0.1, "plunger_diameter_mm": 9.9, "skin_thickness_mm": 4}, data / "rig.yaml")
    hidden = [{"cause": truth.cause, "form": truth.form, "amplitude": truth.amplitude}] if cause else []
    return {"hidden": hidden, "noise_rms": truth.noise_rms, "width": truth.width, "stiffness": truth.stiffness}


def main():
    """Command line: FOLDER [--count 200] [--seed 0] [--first 0]."""
    parser = argparse.ArgumentParser("world.blind", description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--count", type=int, default=200)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    o = parser.parse_args()
    sealed = o.folder / "sealed" / "answers.json"
    sealed.parent.mkdir(parents=True, exist_ok=True)
    answers = json.loads(sealed.read_text()) if sealed.exists() else {}
    for index in range(o.first, o.first + o.count):
        answers[f"case_{index:03d}"] = make_case(index, o.seed, o.folder)
        sealed.write_text(json.dumps(answers, indent=1, default=_plain))
        print(f"\r{index - o.first + 1}/{o.count}", end="", flush=True)
    print(f"\n{len(answers)} answers in {sealed}")


def _plain(value):
    return value.tolist() if isinstance(value, (np.ndarray, np.generic)) else str(value)


if __name__ == "__main__":
    main()
