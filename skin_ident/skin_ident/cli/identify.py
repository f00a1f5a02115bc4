"""`identify --until-named --out DIR`: alternate experiments on the simulated rig with diagnosis until one cause is left."""

import argparse
import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np

from skin_ident.cli import common
from skin_ident.cli.diagnose import progress_line, write
from skin_ident.criticism.sessions.session import prepare
from skin_ident.criticism.vocabulary import word_of
from skin_ident.hiding.drawing import ANYTHING, NOTHING, check_cause, draw
from skin_ident.hiding.errors import HidingError
from skin_ident.hiding.simulated_rig import SimulatedRig, varied
from skin_ident.hiding.writing import check_free, write_recordings
from skin_ident.recordings.load import load_one
from skin_ident.recordings.recording import Recording
from skin_ident.report.numbers import amount
from skin_ident.report.terminal import summary
from skin_ident.separating.loop import Course, Record, until_named
from skin_models.effect import Effect
from skin_models.materials import material
from skin_models.model import Model
from skin_models.model_file import load_model, save_model
from skin_models.parameter import parameters_of
from skin_models.words import counted
from skin_motion_profiles.profile_file import entry_from_words

FASTER = 4.0  # than real time, on the live rig


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    if not 0.0 < chosen.budget < math.inf:
        raise HidingError(f"--budget is in seconds of recording and positive, not {chosen.budget:g}")
    if chosen.specimen and chosen.cause != ANYTHING:
        raise HidingError("--specimen says what is in the specimen, and --cause hides something in one that is drawn: give one of them")
    check_cause(chosen.cause, NOTHING)
    common.check_seed(chosen.seed)
    (common.check_empty if chosen.live else common.check_output)(chosen.out)  # a bag is not written over anything
    common.check_no_model(chosen.out)
    check_free(Path(chosen.out) / "recordings")
    specimen = load_model(chosen.specimen) if chosen.specimen else _specimen(chosen.cause, chosen.seed, chosen.first)
    entry_from_words(chosen.first), entry_from_words(chosen.fixed)  # raises before anything is written
    folder, say = common.output_folder(chosen.out), progress_line()
    with _rig(chosen, specimen, folder) as record:
        course = until_named(record, chosen.first, chosen.fixed, chosen.budget if chosen.until_named else 0.0, say)
        say(f"the fixed battery {chosen.fixed}, for comparison")
        fixed = until_named(record, chosen.fixed, chosen.fixed, 0.0, say)
    write(course.outcome, folder)
    save_model(specimen, folder / "specimen.yaml")
    common.write_json(folder / "experiments.json", {"course": _told(course), "fixed": _told(fixed)})
    if not chosen.live:
        write_recordings(list(course.recordings), folder / "recordings")
    common.clear_line()
    account = f"{_account(course, fixed, chosen.fixed)}\n{_truth(specimen, course)}"
    print(f"{summary(course.outcome.findings)}\n\n{account}\nreport: {folder / 'report.html'}")
    return 0


def _specimen(cause: str, seed: int, first: str) -> Model:
    """Silicone of 4 mm, another specimen for every seed, with an effect of typical size. Raises `HidingError`."""
    plain = varied(material("silicone_4mm").model, seed)
    if cause == NOTHING:
        return plain
    session = prepare(SimulatedRig().record(plain, entry_from_words(first), seed))
    return plain.extended(draw(session, cause, ANYTHING, np.random.default_rng([seed, 5])))


@contextmanager
def _rig(chosen: argparse.Namespace, specimen: Model, folder: Path) -> Iterator[Record]:
    """What records a battery: a simulation in this process, or driver, profile server and recorder as processes of their own."""
    if not chosen.live:
        yield _numbered(lambda battery, name, i: SimulatedRig().record(specimen, entry_from_words(battery), 100 * chosen.seed + i, name))
        return
    from skin_ident.ros.testbed import TARE, Testbed  # needs an installed workspace

    hidden = folder / "specimen.yaml"
    save_model(specimen, hidden)
    with Testbed(hidden, chosen.seed, FASTER) as testbed:
        testbed.execute(TARE)
        yield _numbered(lambda battery, name, i: replace(load_one(testbed.session(folder / f"{i}_{name}", battery)), name=name))


def _numbered(record: Callable[[str, str, int], Recording]) -> Record:
    count = iter(range(1, 1_000_000))
    return lambda battery, name: record(battery, name, next(count))


def _told(course: Course) -> list[dict]:
    return [{"battery": s.battery, "seconds": s.seconds, "left": s.left} for s in course.steps]


def _account(course: Course, fixed: Course, name: str) -> str:
    n, last, other = len(course.steps), course.steps[-1], fixed.steps[-1]
    longer = course.seconds - fixed.seconds
    compared = f"\nthe loop recorded {longer:.0f} s more than the fixed battery" if longer > 0.0 else ""
    return (
        f"{counted(n, 'experiment')}, {course.seconds:.0f} s of recording, named: {last.words}\n"
        f"the fixed battery {name}, {fixed.seconds:.0f} s of recording, named: {other.words}{compared}"
    )


def _truth(specimen: Model, course: Course) -> str:
    """What was hidden in the specimen, and whether it was named, a line for each effect."""
    said = [_one_truth(effect, course.steps[-1].left) for effect in specimen.effects]
    none = "something was named all the same" if course.steps[-1].left else "nothing was named"
    return "\n".join(said) or f"hidden in the specimen: nothing; {none}"


def _one_truth(effect: Effect, left: tuple[tuple[str, ...], ...]) -> str:
    name, alone = _placed(effect), [names for names in left if len(names) == 1]
    verdict = (
        "it was named"
        if (name,) in alone
        else "it is among the names that are left"
        if any(name in n for n in left)
        else "it was not named"
    )
    sizes = ", ".join(f"{p.name} {amount(p.value, p.unit)}" for p in parameters_of(effect) if p.value)
    return f"hidden in the specimen: {name} ({sizes}); {verdict}"


def _placed(effect: Effect) -> str:
    """An effect in the words of the steps of a course."""
    return f"{effect.cause} in the {word_of(effect.where)}"


def _parser() -> argparse.ArgumentParser:
    parser = common.Parser(prog="identify", description=__doc__)
    parser.add_argument("--until-named", action="store_true", help="go on until one name is left; without it one experiment is made")
    parser.add_argument("--specimen", metavar="YAML", help="model of the specimen in the rig; default: silicone with something hidden")
    parser.add_argument("--cause", default=ANYTHING, help=f"what to hide in it, or {NOTHING}; default: drawn at random")
    parser.add_argument("--seed", type=int, default=0, help="seed of the specimen and all noise (0)")
    parser.add_argument("--first", default="sinusoidal_identification", metavar="BATTERY", help="first battery (the thesis's four sines)")
    parser.add_argument("--fixed", default="full", metavar="BATTERY", help="the fixed battery to compare with (full)")
    budget = "seconds of recording after which no experiment is begun; one that runs then is finished (600)"
    parser.add_argument("--budget", type=float, default=600.0, help=budget)
    parser.add_argument("--live", action="store_true", help="driver, profile server and recorder instead of a simulation in this process")
    parser.add_argument("--out", required=True, metavar="DIR", help="where recordings, findings, model and report go")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
