"""`fit RECORDING… --out DIR`: the dispersion model of one or many sessions, with an uncertainty and a verdict for every parameter."""

import argparse
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from skin_ident.cli import common
from skin_ident.estimators.dispersion import FREE, fit_dispersion, known_mass
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import Estimate
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.estimators.sinusoid import as_sinusoids
from skin_ident.estimators.text import as_dict, as_table
from skin_ident.recordings.load import load
from skin_ident.recordings.recording import Recording
from skin_models.model_file import save_model


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    chosen = _parser().parse_args(arguments)
    topics = common.topics_of(chosen.topics)
    common.say(f"reading {len(chosen.recordings)} path{'s' * (len(chosen.recordings) > 1)} …")
    recordings = sessions_of(load(chosen.recordings, topics))
    common.say(f"fitting {len(recordings)} session{'s' * (len(recordings) > 1)}, {sum(map(len, recordings))} samples …")
    estimate = _estimate(recordings, chosen)
    print(as_table(estimate))
    if chosen.out:
        write(estimate, common.output_folder(chosen.out))
    return 0


def _estimate(recordings: list[Recording], chosen: argparse.Namespace) -> Estimate:
    if all(r.depth is None for r in recordings):
        return fit_force_to_force(recordings, chosen.order)
    mass = _mass(chosen.mass, chosen.thickness_mm, recordings)
    if chosen.motion == "measured":
        return fit_dispersion(recordings, mass, offsets=chosen.offsets)
    parts, motions, sinusoids = as_sinusoids(recordings)
    estimate = fit_dispersion(parts, mass, motions, offsets=chosen.offsets, method="linear least squares on fitted sinusoids")
    return replace(estimate, notes={**estimate.notes, "sinusoids": {r.name: vars(s) for r, s in zip(recordings, sinusoids, strict=True)}})


def write(estimate: Estimate, folder: Path) -> None:
    """Write `model.yaml`, which the skin node loads, and `fit.json`."""
    common.write_json(folder / "fit.json", as_dict(estimate))
    if estimate.model is None:
        common.say(f"wrote {folder / 'fit.json'}; no model.yaml, for without a depth only ratios are known")
        return
    save_model(estimate.model, folder / "model.yaml", estimate.std)
    common.say(f"wrote {folder / 'model.yaml'} and {folder / 'fit.json'}")


def sessions_of(loaded: list) -> list[Recording]:
    """The sessions among what was loaded. Raises `FitError` where there is only a static scan."""
    sessions = [r for r in loaded if isinstance(r, Recording)]
    if not sessions:
        raise FitError(f"{loaded[0].name} is a static spread scan, which has no dispersion model; give it to diagnose")
    for scan in (r for r in loaded if not isinstance(r, Recording)):
        common.say(f"{scan.name} is a static spread scan: left out of the fit")
    return sessions


def _mass(text: str, thickness_mm: float | None, recordings: list[Recording]) -> float | str:
    if text in (FREE, "fixed"):
        return FREE if text == FREE else known_mass(recordings, thickness_mm)
    try:
        mass = float(text)
    except ValueError:
        raise FitError(f"--mass takes free, fixed, or a number in kg, not {text!r}") from None
    if not 0.0 <= mass < 1e3:
        raise FitError(f"--mass {text}: a mass in kg must not be negative, nor a ton")
    return mass


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="fit", description=__doc__)
    common.add_recordings(parser)
    parser.add_argument("--mass", default="fixed", help="free, fixed (from rig.yaml or the thickness; the default), or a value in kg")
    parser.add_argument("--thickness_mm", type=float, help="thickness of the skin, for the fixed mass")
    parser.add_argument(
        "--motion", default="measured", choices=("measured", "sinusoid"), help="depth as measured, or the sinusoid fitted to it"
    )
    parser.add_argument("--offsets", action="store_true", help="fit a zero of every channel in every session, too")
    parser.add_argument("--order", type=int, default=1, choices=(1, 2), help="from force to force: 1 without mass, 2 as thesis eq 32")
    parser.add_argument("--out", metavar="DIR", help="where model.yaml and fit.json go; left out: nothing is written")
    return parser


if __name__ == "__main__":
    raise SystemExit(main())
