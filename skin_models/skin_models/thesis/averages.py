"""Recomputes the averages, standard deviations and derived numbers of chapters 3 and 4.

How the thesis forms them was found by trying what gives its digits:

    Tables 3-1, 3-2   std with n (not n - 1) over the four runs of a taxel
    Table 4-4 means   mean over all runs: each specimen's mean weighted with its runs (4mm_1 was tested once, all others three times)
    Table 4-4 std     2 and 6 mm: std with n between the three specimens' means
                      4 mm: std with n over all seven runs, so specimens and repetitions together; not comparable with the other two
    mass              density of 1190 kg/m^3 times a *square* block of the taxel's 9.53 mm, times the thickness
                      (a disc would need 1515 kg/m^3)
"""

from collections.abc import Iterator

import numpy as np

from skin_models.thesis.comparison import Comparison, compare
from skin_models.thesis.printed import Printed
from skin_models.thesis.tables import PARAMETERS, table

RUNS = ("1", "2", "3", "4")
BY_SPECIMEN = {"2mm": "4-1", "4mm": "4-2", "6mm": "4-3"}
BLOCK_DENSITY = 1190.0  # kg/m^3; not printed, found from the masses

_NOTES = {
    ("4-4", "2mm b1"): "the mean of 1464.4, 1286.1 and 1242.1 is 1330.9: cut off instead of rounded",
    ("4-4", "2mm b1_std"): "the three specimens' means give 96.1 however their last digits fall: a slip in the last digit",
}


def comparisons() -> list[Comparison]:
    """All recomputed entries of Tables 3-1, 3-2, 4-4, 4-5 and of the text."""
    return [*_taxels("3-1"), *_taxels("3-2"), *_thicknesses(), *_fixed_mass(), *_masses(), *_text()]


def _compare(name: str, entry: str, printed: Printed, function, inputs) -> Comparison:
    return compare(name, entry, printed, function, list(inputs), _NOTES.get((name, entry), ""))


def _taxels(name: str) -> Iterator[Comparison]:
    t = table(name)
    for taxel in t.columns:
        runs = t.column(taxel, RUNS)
        yield _compare(name, f"{taxel} average", t.cell("average", taxel), np.mean, runs)
        yield _compare(name, f"{taxel} std", t.cell("std", taxel), np.std, runs)


def _thicknesses() -> Iterator[Comparison]:
    for thickness, name in BY_SPECIMEN.items():
        specimens, printed = table(name), table("4-4").rows[thickness]
        runs = np.array([1 if std is None else 3 for std in specimens.column("m_std")])
        for p in PARAMETERS:
            means = specimens.column(p)
            within = [Printed("0") if std is None else std for std in specimens.column(f"{p}_std")]
            yield _compare("4-4", f"{thickness} {p}", printed[p], lambda x, n=runs: n @ x / n.sum(), means)
            if np.all(runs == 3):
                yield _compare("4-4", f"{thickness} {p}_std", printed[f"{p}_std"], np.std, means)
            else:
                yield _compare("4-4", f"{thickness} {p}_std", printed[f"{p}_std"], lambda x, n=runs: _std_of_runs(x, n), means + within)


def _std_of_runs(means_and_std: np.ndarray, runs: np.ndarray) -> float:
    """Standard deviation (with n) over all runs from each specimen's mean and standard deviation (with n)."""
    means, std = np.split(means_and_std, 2)
    mean = runs @ means / runs.sum()
    return float(np.sqrt(runs @ ((means - mean) ** 2 + std**2) / runs.sum()))


def _fixed_mass() -> Iterator[Comparison]:
    """b1 and k1 do not depend on the mass (eq 28): Table 4-5 must repeat Table 4-4."""
    for thickness, printed in table("4-5").rows.items():
        for column in ("b1", "b1_std", "k1", "k1_std"):
            yield _compare("4-5", f"{thickness} {column}", printed[column], lambda x: x[0], [table("4-4").cell(thickness, column)])


def _masses() -> Iterator[Comparison]:
    side = table("text").cell("taxel_diameter", "value")
    for mm in (2, 4, 6):
        entry = f"mass_{mm}mm"
        printed = table("text").cell(entry, "value")
        yield _compare("text", entry, printed, lambda d, h=mm: 1e-6 * BLOCK_DENSITY * d[0] ** 2 * h, [side])


def _text() -> Iterator[Comparison]:
    said = {row: cells["value"] for row, cells in table("text").rows.items()}
    free, fixed = table("4-4"), table("4-5")
    yield _compare("text", "b2_decrease", said["b2_decrease"], _decrease, free.column("b2") + fixed.column("b2"))
    for mm in ("2mm", "4mm", "6mm"):
        entry = f"k2_decrease_{mm}"
        yield _compare("text", entry, said[entry], _decrease, [free.cell(mm, "k2"), fixed.cell(mm, "k2")])
    relative = [said[f"relative_mse_{mm}"] for mm in ("2mm", "4mm", "6mm")]
    yield _compare("text", "relative_mse_average", said["relative_mse_average"], np.mean, relative)
    yield _compare("text", "pressure_of_5_n", said["pressure_of_5_n"], lambda d: 5e3 / (np.pi / 4 * d[0] ** 2), [said["taxel_diameter"]])
    yield from _widths(said)


def _decrease(x: np.ndarray) -> float:
    before, after = np.split(x, 2)
    return float(np.mean(before - after))


def _widths(said: dict) -> Iterator[Comparison]:
    silicone = table("4-8").column("c", ("0.40", "0.50", "0.60", "0.70", "0.80", "0.90", "0.99"))
    yield _compare("text", "average_c_silicone", said["average_c_silicone"], np.mean, silicone)
    frubber = [c for c in table("4-9").column("c") if c is not None]
    yield _compare("text", "average_c_frubber", said["average_c_frubber"], np.mean, frubber)
