"""`thesis`: the experiments of the thesis repeated on its rig in simulation, and what its tables say when they are read closely."""

import textwrap
from collections.abc import Sequence
from typing import Any

import numpy as np

from skin_ident import thesis_repeat as again
from skin_ident.cli import common
from skin_ident.criticism.scan.thesis import thesis_findings, thesis_spread
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import HALF_95
from skin_ident.estimators.figures import plus_minus
from skin_ident.thesis_dispersion import FreeMass, free_masses, speed_exponents
from skin_models.thesis.comparison import Disagreement
from skin_models.thesis.tables import estimates

MG = 1e6  # kg to mg


def main(arguments: Sequence[str] | None = None) -> int:
    """Entry point; returns the exit status."""
    return common.run(_main, arguments)


def _main(arguments: Sequence[str] | None) -> int:
    parser = common.Parser(prog="thesis", description=__doc__)
    parser.add_argument("--out", metavar="DIR", help="where thesis.json goes; default: nothing is written")
    parser.add_argument("--runs", type=int, default=10, help="number of runs of the validation, per thickness")
    chosen = parser.parse_args(arguments)
    if chosen.runs < 1:
        raise FitError(f"--runs counts experiments, from 1 on, not {chosen.runs}")
    if chosen.out is not None:
        common.check_output(chosen.out)
    cases, found = free_masses(), {}
    for title, section in (("table_4_5", _fixed), ("table_4_4", _free), ("validation", _validation), ("frubber", _frubber)):
        found[title] = section(cases, chosen.runs)
    found["table_4_10"], found["data_error"] = _spread_scan(), _data_errors()
    if chosen.out:
        path = common.output_folder(chosen.out) / "thesis.json"
        common.write_json(path, found)
        common.say(f"wrote {path}")
    return 0


def _fixed(cases: Sequence[FreeMass], runs: int) -> dict[str, Any]:
    print(f"Table 4-5, mass fixed: specimen, and what {again.TRIALS} sines on chapter 3's rig give back (± 95 %)")
    print(f"  {'':<6}" + "".join(f"{name + ' ' + unit:>26}" for name, unit in zip(again.NAMES, ("N*s/m", "N/m") * 2, strict=True)))
    out: dict[str, Any] = {}
    for case in cases:
        fit, printed = again.recovered(case), estimates("4-5", f"{case.thickness_mm}mm")
        cells = [f"{printed[n].value:>9.5g} {plus_minus(fit.values[n], _half(fit, n)):>14}" for n in again.NAMES]
        print(f"  {case.thickness_mm} mm  " + "".join(f"{cell:>26}" for cell in cells))
        rows = {n: {"specimen": printed[n].value, "value": fit.values[n], "std": fit.std[n]} for n in again.NAMES}
        out[f"{case.thickness_mm}mm"] = rows
    _say("k2 is what is left of the whole after k1: the load cell's own nonlinearity and hysteresis, tenths of a percent of the whole, end "
         "up in it, and no interval from the scatter of one rig can know.")  # fmt: skip
    return out


def _half(fit: Any, name: str) -> float:
    low, high = fit.interval(name)
    return (high - low) / 2


def _free(cases: Sequence[FreeMass], runs: int) -> dict[str, Any]:
    print("\nTable 4-4, mass free: the same data fitted with the mass free, and with it fixed")
    out: dict[str, Any] = {}
    for case in cases:
        free, fixed = again.free_and_fixed(case)
        printed = [estimates(t, f"{case.thickness_mm}mm") for t in ("4-4", "4-5")]
        fall, told = free.values["k2"] - fixed.values["k2"], printed[0]["k2"].value - printed[1]["k2"].value
        verdict = free.verdicts["m"]
        print(f"  {case.thickness_mm} mm: m = {free.values['m']:.3g} kg (thesis {printed[0]['m'].value:.3g}), the skin's own "
              f"{MG * case.known:.3g} mg; k2 falls by {fall:.0f} N/m when it is fixed (thesis {told:.0f})")  # fmt: skip
        print(textwrap.fill(f"m {verdict.word}: {verdict.sentence}", 110, initial_indent=" " * 8, subsequent_indent=" " * 8))
        out[f"{case.thickness_mm}mm"] = {
            "mass_kg": free.values["m"], "mass_of_the_skin_kg": case.known, "verdict": verdict.word, "because": verdict.sentence,
            "constant_force_n": -case.force, "fall_of_k2": fall, "fall_of_k2_in_the_thesis": told,
        }  # fmt: skip
    depths = ", ".join(f"{1e3 * case.amplitude:.2f}" for case in cases)
    _say(f"A fall of m g C / (C² + A²/2) is what a sine with A = C of {depths} mm gives: so deep the thesis must have pressed, which it "
         "does not say.")  # fmt: skip
    return out


def _validation(cases: Sequence[FreeMass], runs: int) -> dict[str, Any]:
    print(f"\nValidation on pseudo-random moves, relative mean squared error of the sensed force: median (least … most) of {runs} runs")
    out: dict[str, Any] = {}
    for case in cases:
        own, mean, printed = again.validation(case, runs), again.averages(case, runs), again.PRINTED[case.thickness_mm]
        head = f"  {case.thickness_mm} mm: identified on the same sample {_spread(own)}"
        print(f"{head}; averages of Table 4-5 {_spread(mean)}; thesis {100 * printed:.2f} %")
        out[f"{case.thickness_mm}mm"] = {"same_sample": own, "averages": mean, "in_the_thesis": printed}
    _say("The first is what hysteresis and drift of a FlexiForce leave. The second is what the thesis did: its averages against a sample "
         "that scatters as Table 4-5 says, on another FlexiForce. Its own numbers are of that kind and size.")  # fmt: skip
    return out


def _spread(errors: np.ndarray) -> str:
    low, middle, high = (100 * float(v) for v in np.percentile(errors, [0, 50, 100]))
    return f"{middle:.2g} % ({low:.2g} … {high:.2g})"


def _say(text: str) -> None:
    print(textwrap.fill(text, 110, initial_indent="  ", subsequent_indent="  "))


def _frubber(cases: Sequence[FreeMass], runs: int) -> dict[str, Any]:
    print("\nFrubber, Table 4-7: the coefficients of eq 32 from 0.25 to 1 mm/s")
    powers = speed_exponents()
    for i, e in enumerate(powers):
        print(f"  experiment 1 to {i + 2}: dampings grow as speed^{e.damping:.2f}, stiffnesses as speed^{e.stiffness:.2f}, while the "
              f"share k1 / (k1 + k2) goes from {e.shares[0]:.2f} to {e.shares[1]:.2f}")  # fmt: skip
    f = again.frubber()
    _say("Material constants would not change with speed; a response that depends on the path and not on the time taken changes so. "
         f"Predicting experiment 3 (1 mm/s) on random moves misses by a relative mean squared error of {100 * f.same_speed:.2g} % with "
         f"experiment 2 (1 mm/s), {100 * f.slower:.2g} % with experiment 1 (0.25 mm/s), {100 * f.average:.2g} % with their average, which "
         "the thesis took. Its 15.5 % is thus no matter of the speed it averaged over, but of what no such filter has.")  # fmt: skip
    return {"speed_exponents": [vars(e) for e in powers], "relative_mse": vars(f), "in_the_thesis": again.PRINTED_FRUBBER}


def _spread_scan() -> dict[str, Any]:
    print("\nTable 4-10, silicone: the force at 0 to 12 mm from the taxel, diagnosed as a measured scan")
    outcome, gain = thesis_spread()
    for f in outcome.findings["findings"]:
        numbers = ", ".join(f"{name} {p['value']:.3g} ± {HALF_95 * p['std']:.1g}" for name, p in f["parameters"].items())
        low, high = f["gain"]["ci95"]
        print(f"  {f['cause']} ({f['means']}): {numbers}; held out by depth, RMSE {f['gain']['held_out_rmse_before']:.3f} to "
              f"{f['gain']['held_out_rmse_after']:.3f} N, less by {low:.3f} to {high:.3f} N with 95 %")  # fmt: skip
    _say("Distances that were not fitted are missed by a Gaussian of its own at every depth, as in Table 4-8, by "
         f"{gain.table_4_8:.3f} N, one width for all depths {gain.gaussian:.3f} N, the extended shape {gain.extended:.3f} N.")  # fmt: skip
    return {"findings": outcome.findings["findings"], "rmse_n": vars(gain)}


def _data_errors() -> list[dict[str, str]]:
    found = thesis_findings()
    print(f"\ndata_error: {len(found)} printed entries that the data printed beside them cannot give, however these were rounded")
    for (table, why), entries in _by_reason(found).items():
        where = "Text" if table == "text" else f"Table {table}"
        _say(f"{where}, {'; '.join(f'{d.entry}: {_shown(d)}' for d in entries)} ({why})")
    return [{"table": d.table, "entry": d.entry, "printed": d.printed, "recomputed": d.recomputed, "why": d.why} for d in found]


def _by_reason(found: Sequence[Disagreement]) -> dict[tuple[str, str], list[Disagreement]]:
    """Entries of one table that are wrong for the same reason, together."""
    out: dict[tuple[str, str], list[Disagreement]] = {}
    for d in found:
        out.setdefault((d.table, d.why), []).append(d)
    return out


def _shown(d: Disagreement) -> str:
    known = any(character.isdigit() for character in d.recomputed)
    return f"printed {d.printed}" + (f", recomputed {d.recomputed}" if known else "")


if __name__ == "__main__":
    raise SystemExit(main())
