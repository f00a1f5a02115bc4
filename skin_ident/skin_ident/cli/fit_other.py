"""`fit --what prony`, `calibration` or `stiffness`: what else holds, stairs and slow presses determine, as a table and as files."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from types import MappingProxyType
from typing import Any

from skin_ident.cli import common
from skin_ident.estimators.calibration import Lines, as_rig_yaml, calibrate, direct_load, stiffness
from skin_ident.estimators.estimate import HALF_95
from skin_ident.estimators.figures import figures, plus_minus
from skin_ident.estimators.prony import NO_RELAXATION, Arm, PronyFit, fit_prony
from skin_ident.recordings.assemble import UNCALIBRATED
from skin_ident.recordings.carried import said_of
from skin_ident.recordings.recording import Recording
from skin_models.model_file import save_model
from skin_models.words import counted

DISPERSION, PRONY, CALIBRATION, STIFFNESS = "dispersion", "prony", "calibration", "stiffness"
WHAT = (DISPERSION, PRONY, CALIBRATION, STIFFNESS)
WIDE = 20  # columns of the table


def fit_other(
    what: str, recordings: Sequence[Recording], out: str | None, arms: int | None = None, in_use: Mapping[str, float] = MappingProxyType({})
) -> int:
    """Print what was asked for and, where `out` is a folder, write it there. `in_use` are slopes (N/V) by taxel that the recordings keep,
    with which calibrated ones are compared. Raises `FitError`."""
    if what == PRONY:
        return _prony(recordings, out, arms)
    lines = calibrate(recordings) if what == CALIBRATION else stiffness(recordings)
    notes = direct_load(recordings) if what == CALIBRATION else []
    recordings = [recordings[0].warned(*notes), *recordings[1:]] if notes else recordings
    print("\n".join(_lines(what, recordings, lines, in_use)))
    if out:
        folder, method = common.output_folder(out), f"{what}, straight lines by least squares"
        sources = _sources(recordings, lines.notes)
        common.write_json(folder / "fit.json", {"schema": 1, "method": method, **sources, what: _each(lines)})
        common.say(f"wrote {folder / 'fit.json'}")
    return 0


def _sources(recordings: Sequence[Recording], notes: Sequence[str] = ()) -> dict[str, Any]:
    said = [said_of(r.name, w) for r in recordings for w in r.warnings]
    return {"recordings": [r.name for r in recordings], "warnings": [*said, *notes]}


def _each(things: Mapping[str, Any]) -> dict[str, Any]:
    return {name: asdict(thing) for name, thing in things.items()}


def _of(recordings: Sequence[Recording]) -> str:
    return f"{counted(len(recordings), 'session')} ({', '.join(r.name for r in recordings)}), ± 95 %"


def _lines(what: str, recordings: Sequence[Recording], lines: Lines, in_use: Mapping[str, float]) -> list[str]:
    against, unit, zero = ("load cell", "N/V", (1.0, "V")) if what == CALIBRATION else ("depth", "N/m", (1e3, "mm"))
    out = [f"{what} against the {against}: {_of(recordings)}"]
    out += [
        f"  {name:<10} {plus_minus(line.slope, HALF_95 * line.slope_std):>{WIDE}} {unit}, zero at {zero[0] * line.zero:.4g} {zero[1]}, "
        f"rms {figures(line.rms)} N, R² {line.r2:.5f}, {counted(line.samples, 'sample')}"
        for name, line in lines.items()
    ]
    if what == CALIBRATION:
        known = {name: (line.slope / in_use[name], in_use[name]) for name, line in lines.items() if name in in_use}
        out += [f"  {name:<10} is {ratio:.3g} times what it was recorded with: {own:.4g} N/V" for name, (ratio, own) in known.items()]
        out += ["for rig.yaml, if the load lay on the taxel itself:", as_rig_yaml(dict(lines)).rstrip()]
    said = _sources(recordings, lines.notes)["warnings"]
    told = [w for w in said if what != CALIBRATION or UNCALIBRATED not in w]  # which is what is asked for
    return out + [f"note: {w}" for w in told]


def _prony(recordings: Sequence[Recording], out: str | None, arms: int | None) -> int:
    fit = fit_prony(recordings, arms)
    print("\n".join(_spectrum(recordings, fit)))
    if out:
        folder = common.output_folder(out)
        found = {"arms": [asdict(arm) for arm in fit.arms], "stiffness": fit.stiffness, "damping": fit.damping, "rmse": fit.rmse}
        pairs = "stiffness and damping hold value and standard error, N/m and N*s/m; times are in s"
        content = {"schema": 1, "method": "Prony series by variable projection", **_sources(recordings), "values": pairs, **found}
        common.write_json(folder / "fit.json", content | {"warnings": fit.warnings})
        if fit.model is not None:
            save_model(replace(fit.model, source=", ".join(r.name for r in recordings)), folder / "model.yaml")
        common.say(f"wrote {folder / 'fit.json'}{' and model.yaml' * (fit.model is not None)}")
    return 0


def _spectrum(recordings: Sequence[Recording], fit: PronyFit) -> list[str]:
    """One row per channel, one column per arm."""
    doubt = ", none of which is sure to be relaxation" * (NO_RELAXATION in fit.warnings)
    out = [f"relaxation spectrum, {counted(len(fit.arms), 'arm')}{doubt}: {_of(recordings)}"]
    heads = ["b N*s/m", "k at rest N/m", *(f"k of arm {i + 1} N/m" for i in range(len(fit.arms)))]
    out.append(f"  {'':<10}" + "".join(f"{head:>{WIDE}}" for head in heads))
    if fit.arms:
        out.append(f"  {'time s':<10}" + " " * 2 * WIDE + "".join(f"{_pair(arm.tau, arm.tau_std):>{WIDE}}" for arm in fit.arms))
    out += [f"  {name:<10}" + "".join(f"{cell:>{WIDE}}" for cell in _cells(fit, name, fit.arms)) for name in fit.stiffness]
    left = ", ".join(f"{name} {figures(rms, 3)} N" for name, rms in fit.rmse.items())
    return [*out, f"what the fit leaves, rms: {left}", *(f"note: {w}" for w in fit.warnings)]


def _cells(fit: PronyFit, name: str, arms: Sequence[Arm]) -> list[str]:
    return [_pair(*fit.damping[name]), _pair(*fit.stiffness[name]), *(_pair(*arm.stiffness[name]) for arm in arms)]


def _pair(value: float, std: float) -> str:
    return plus_minus(value, HALF_95 * std)
