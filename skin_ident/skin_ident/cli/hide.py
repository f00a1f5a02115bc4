"""`hide RECORDING… --out DIR`: hide an effect of chosen or random cause, place and size in recordings, for others to find."""

import argparse
import os
from collections.abc import Sequence
from pathlib import Path

from skin_ident.cli import common
from skin_ident.criticism.usable import belong_together
from skin_ident.hiding.campaign import NULL
from skin_ident.hiding.drawing import ANYTHING, NOTHING, check_cause
from skin_ident.hiding.errors import HidingError
from skin_ident.hiding.hide import check_size, hide
from skin_ident.hiding.writing import check_free, check_units, whole_recordings
from skin_ident.recordings.load import find, load
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.repeated import first_repeat
from skin_models.words import counted


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    common.check_output(chosen.out)
    check_free(Path(chosen.out))
    common.check_seed(chosen.seed)
    if chosen.cause in (NOTHING, NULL):
        raise HidingError(
            f"hide always hides something: hiding nothing is what challenge --causes {NULL} and identify --cause {NOTHING} do"
        )
    check_cause(chosen.cause)
    check_size(chosen.size)
    truth = _truth_file(chosen.truth, Path(chosen.out))
    topics, files = common.topics_of(chosen.topics), [file for path in chosen.recordings for file in find(path)]
    recordings = _sessions(load(files, topics, chosen.log_time), files)
    common.say(f"hiding an effect in {counted(len(recordings), 'session')} …")
    changed, hidden = hide(recordings, chosen.cause, chosen.where, chosen.size, chosen.seed)
    folder = common.output_folder(chosen.out)
    common.output_folder(str(truth.parent))
    with whole_recordings(changed, folder) as tables:
        told = {"hidden": [hidden.as_dict()], "recordings": [r.name for r in recordings], "tables": [t.name for t in tables]}
        common.write_json(truth, told)
    if hidden.hardly_seen:
        common.say(f"warning: {hidden.hardly_seen}")
    common.say(f"wrote {counted(len(tables), 'table')} into {folder}, and the truth (to be read after the search only) into {truth}")
    return 0


def _sessions(loaded: list, files: list[Path]) -> list[Recording]:
    """What was loaded from `files`. Raises `HidingError` for what nothing can be hidden in, and for a measurement that is there twice."""
    scans = [r.name for r in loaded if not isinstance(r, Recording)]
    if scans:
        raise HidingError(f"{scans[0]} is a static spread scan; effects are hidden in sessions only")
    check_units(loaded)
    belong_together(loaded)
    repeat = first_repeat(loaded)
    if repeat:  # no rig records the same samples in two sessions
        one, other = (files[i] for i in repeat)
        what = f"{one} is given twice" if one.resolve() == other.resolve() else f"{one} and {other} hold the same samples"
        raise HidingError(f"{what}: an effect is hidden in each recording once, leave one out")
    return loaded


def _truth_file(given: str | None, out: Path) -> Path:
    """Where the truth goes. Raises `HidingError` where that is beside the data, or something is there already."""
    if not out.resolve().name:
        raise HidingError(f"the truth would lie beside the data in {out}: name another folder with --out")
    truth = Path(given) if given else out.resolve().with_name(out.resolve().name + "_truth.json")
    if truth.is_dir():
        raise HidingError(f"--truth {truth} is a folder: name a file")
    if out.resolve() in truth.resolve().parents:
        raise HidingError(f"--truth {truth} lies beside the data: whoever searches would find it; write it elsewhere")
    if os.path.lexists(truth):
        raise HidingError(f"{truth} exists already, and nothing is overwritten: name another file with --truth")
    return truth


def _parser() -> argparse.ArgumentParser:
    parser = common.Parser(prog="hide", description=__doc__)
    common.add_recordings(parser)
    parser.add_argument("--cause", default=ANYTHING, help="a cause of the vocabulary; default: drawn at random")
    parser.add_argument("--where", default=ANYTHING, help="its place; default: drawn at random")
    parser.add_argument(
        "--size",
        type=float,
        default=1.0,
        help="RMS of the effect divided by that of the noise, in the channel that shows it best (1.0). Counted is what the "
        "fitted model cannot imitate; where it imitates more than nine tenths (as the gain of a lone taxel) all is counted, with a warning",
    )
    parser.add_argument("--seed", type=int, default=0, help="seed of everything that is drawn (0)")
    parser.add_argument("--truth", metavar="FILE", help="where the truth goes; default: <DIR>_truth.json, beside the folder")
    parser.add_argument("--out", required=True, metavar="DIR", help="where tables and rig.yaml go")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
