"""The whole diagnosis, end to end, on a simulated rig in which a seed has hidden an effect:

    rig with something hidden ─► sessions through the action ─► MCAP bags ─► diagnosis ─► extended model ─► simulated skin, live

    ./skin demo [--seed N] [--effect CAUSE|none] [--out DIR]

Every node is a process of its own on a private ROS domain. What was hidden is only compared with the findings at the very end.
"""

import argparse
import random
import sys
import time
from collections.abc import Sequence
from datetime import datetime
from pathlib import Path

import numpy as np
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from skin_ident.cli import common
from skin_ident.cli.diagnose import write as write_diagnosis
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.vocabulary import ZERO_OF_DEPTH
from skin_ident.recordings.load import load
from skin_ident.report.numbers import amount
from skin_ident.report.terminal import summary
from skin_ident.ros.testbed import TARE, Testbed
from skin_models.catalogue import effect_class
from skin_models.effect import Effect
from skin_models.errors import SkinError
from skin_models.materials import material
from skin_models.model import Model
from skin_models.model_file import save_model
from skin_models.parameter import parameters_of

HIDEABLE = {  # without zero offsets of sensors: the tare removes them
    "stress_relaxation": "skin",
    "nonlinear_stiffness": "skin",
    "hysteresis": "skin",
    "backlash": "rig",
    "friction": "load_cell",
    "lag": "taxel",
    "saturation": "taxel",
}
SCREW = (
    "\n        (the screw of the simulated rig puts the plunger up to 2.5 µm beside what its encoder reads: the same as a zero of depth)"
)
UNCHANGED = "    (nothing was added to the model: before and after are the same one, fitted twice, and what differs here is no gain)"
NOTHING = "none"
SECRET = "secret_specimen.yaml"
SESSIONS = 3
FASTER = 4.0  # than real time
LATER = 100  # added to the seed for the last comparison, which is thus another run than the sessions
MOST = 2**31 - 1  # what the driver takes for a seed


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    seed = random.SystemRandom().randrange(10_000) if chosen.seed is None else chosen.seed
    common.check_seed(seed, MOST - LATER)
    out = f"skin_demo_{datetime.now():%Y-%m-%d_%H-%M-%S}" if chosen.out is None else chosen.out
    common.check_empty(out)
    specimen, hidden = specimen_with_secret(seed, chosen.effect)
    folder, tell = common.output_folder(out), Teller()
    save_model(specimen, folder / SECRET)
    tell(f"seed {seed}: {_announced(chosen.effect)}")
    try:
        bags = record_sessions(folder, seed, tell)
    except BaseException:
        if not any(folder.glob("session_*")):  # without a recording it is of no use, and would have the same call refused
            (folder / SECRET).unlink(missing_ok=True)
        raise
    tell("diagnosing: two sessions to fit, one held out")
    outcome = diagnose(load(bags[:-1]), load(bags[-1:]), None)
    write_diagnosis(outcome, folder)
    print(summary(outcome.findings))
    tell("running the simulated skin beside the rig, with the model before and after")
    print(live_comparison(folder, seed, tell))
    if outcome.model is not None and not outcome.model.effects:
        print(UNCHANGED)
    print(answer(hidden, outcome.findings))
    print(f"\nlook at  {folder / 'before_after.png'}\nread     {folder / 'report.html'}")
    print(f"use      ./skin run skin_models skin_node --ros-args -p model:={folder.resolve() / 'model.yaml'}")
    return 0


def specimen_with_secret(seed: int, cause: str | None) -> tuple[Model, Effect | None]:
    """Silicone of 4 mm with one effect of the catalogue in it, drawn by `seed` unless `cause` names it. Raises `SkinError`."""
    rng = random.Random(seed)
    cause = cause or rng.choice(list(HIDEABLE))
    plain = material("silicone_4mm").model
    if cause == NOTHING:
        return plain, None
    if cause not in HIDEABLE:
        raise SkinError(f"--effect {cause!r} is not one that the demo hides: choose from {', '.join(HIDEABLE)}, {NOTHING}")
    cls = effect_class(cause, HIDEABLE[cause])
    effect = cls.typical(HIDEABLE[cause])
    return plain.extended(effect), effect


def _announced(cause: str | None) -> str:
    """What may be said beforehand: nothing that the user does not know yet."""
    if cause is None:
        return "the rig hides something (the answer comes last)"
    return "the rig hides nothing, as you asked" if cause == NOTHING else f"the rig hides {cause}, as you asked"


def record_sessions(folder: Path, seed: int, tell: "Teller") -> list[Path]:
    """Record `SESSIONS` sessions of the demo battery, each with its own seed, into bags."""
    tell("starting driver, profile server and recorder")
    with Testbed(folder / SECRET, seed, FASTER) as testbed:
        tell("taring in free air")
        testbed.execute(TARE)
        bags = []
        for i in range(SESSIONS):
            tell(f"recording session {i + 1} of {SESSIONS}")
            bags.append(testbed.session(folder / f"session_{i + 1}", "demo", f"seed={seed + i}"))
    return bags


def live_comparison(folder: Path, seed: int, tell: "Teller") -> str:
    """Run the rig once more with two simulated skins following its encoder, before and after; returns a table of their errors."""
    with Testbed(folder / SECRET, seed + LATER, FASTER) as testbed:
        testbed.simulate_beside(folder / "baseline.yaml", "before")
        testbed.simulate_beside(folder / "model.yaml", "after")
        testbed.execute(TARE)
        tell("recording rig and simulations together")
        bag = testbed.session(folder / "live", "demo", f"seed={seed + LATER}")
    return error_table(bag)


def error_table(bag: Path) -> str:
    """RMSE of both simulated skins against the rig over the samples with a common stamp, from a bag in which all three published."""
    with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        rows = {who: _samples(reader, who) for who in ("", "/before", "/after")}
    stamps = sorted(set.intersection(*map(set, rows.values())))
    if not stamps:
        raise SkinError(f"{bag} holds no sample that rig and simulations share")
    measured, before, after = (np.array([row[stamp] for stamp in stamps]) for row in rows.values())
    lines = [f"\n  live, simulated skin against rig, {len(stamps)} samples:    before        after"]
    for c, channel in enumerate(["force", *(f"taxel_{i}" for i in range(measured.shape[1] - 1))]):
        errors = [np.sqrt(np.mean((measured[:, c] - simulated[:, c]) ** 2)) for simulated in (before, after)]
        lines.append(f"    RMSE of {channel:<12}                         {errors[0]:8.4f} N  {errors[1]:8.4f} N")
    lines.append("    (unfiltered: where the speed jumps, a live skin knows it a sample later; the report compares below 8 Hz)")
    return "\n".join(lines)


def _samples(reader: AnyReader, who: str) -> dict[tuple[int, int], np.ndarray]:
    """Force and taxels (N, compression positive) under their stamp; samples that lack one of the two are left out."""
    parts: dict[str, dict[tuple[int, int], np.ndarray]] = {f"{who}/force": {}, f"{who}/taxels": {}}
    for connection, _, raw in reader.messages([c for c in reader.connections if c.topic in parts]):
        message = reader.deserialize(raw, connection.msgtype)
        stamp = message.header.stamp
        values = message.force if connection.topic.endswith("taxels") else [-message.wrench.force.z]
        parts[connection.topic][stamp.sec, stamp.nanosec] = np.asarray(values, float)
    force, taxels = parts.values()
    return {stamp: np.concatenate([force[stamp], taxels[stamp]]) for stamp in force if stamp in taxels}


def answer(hidden: Effect | None, findings: dict) -> str:
    """What was hidden, against what was found, with its rivals; and how large, where both have the same parameters. A zero of depth is not
    hidden, but the rig may have one."""
    own = {p.name: p for p in parameters_of(hidden) if p.value} if hidden else {}
    keys, sizes, found = [(f["cause"], f["where"]) for f in findings["findings"]], [], []
    for key, f in zip(keys, findings["findings"], strict=True):
        same = {n: q for n, q in f["parameters"].items() if n in own and key == hidden.key}
        like = {n: [own[n].value, q["value"]] for n, q in same.items()}
        sizes += [f"{n} {amount(own[n].value, own[n].unit, like=like[n])}" for n in same]
        named = _at(*key, [f"{n} {amount(q['value'], q['unit'], q['std'], like[n])}" for n, q in same.items()])
        found.append(" or ".join([named, *(_at(a["cause"], a["where"]) for a in f["alternatives"])]))
    said = f"\nhidden: {_at(*hidden.key, sizes) if hidden else 'nothing'}\nfound:  {', '.join(found) or 'nothing'}"
    return said + (SCREW if ZERO_OF_DEPTH in keys else "")


def _at(cause: str, where: str, sizes: Sequence[str] = ()) -> str:
    return f"{cause} in the {where}" + (f" ({', '.join(sizes)})" if sizes else "")


class Teller:
    """Prints each stage with the time since the start."""

    def __init__(self) -> None:
        self.started = time.monotonic()

    def __call__(self, stage: str) -> None:
        print(f"[{time.monotonic() - self.started:5.1f} s] {stage}", file=sys.stderr, flush=True)


def _parser() -> argparse.ArgumentParser:
    parser = common.Parser(prog="demo", description="The main job end to end on a simulated rig that hides an effect.")
    parser.add_argument("--seed", type=int, help="what is hidden, and all noise; left out: drawn")
    parser.add_argument("--effect", help=f"hide this one: {', '.join(HIDEABLE)}, {NOTHING}")
    parser.add_argument("--out", metavar="DIR", help="where everything goes, new or empty; left out: skin_demo_<date>_<time>")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
