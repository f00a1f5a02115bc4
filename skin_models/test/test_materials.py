import numpy as np
import pytest
from scipy.signal import lsim

from skin_models.errors import ModelError
from skin_models.materials import SCALED, SILICONE, free_mass, frubber_transmission, material, names, population, silicone
from skin_models.thesis.tables import estimates, table


def test_four_skins_are_shipped():
    assert names() == ("frubber_4mm", *SILICONE)


@pytest.mark.parametrize(
    ("name", "source", "row"), [*((f"silicone_{h}mm", "4-5", f"{h}mm") for h in (2, 4, 6)), ("frubber_4mm", "4-6", "4mm")]
)
def test_files_say_what_the_tables_say(name, source, row):
    skin = material(name)
    for p, printed in estimates(source, row).items():
        assert getattr(skin.model.dispersion, p) == printed.value and skin.std[p] == printed.std, p
    assert skin.thickness == pytest.approx(float(row[0]) * 1e-3)


@pytest.mark.parametrize(("h", "samples"), [(2, "4-1"), (4, "4-2"), (6, "4-3")])
def test_unit_to_unit_variation_is_that_between_the_specimens(h, samples):
    skin = material(f"silicone_{h}mm")
    for p in ("b1", "k1"):
        means = [c.value for c in table(samples).column(p)]
        assert skin.unit_to_unit[p] == pytest.approx(np.std(means, ddof=1), rel=1e-3)


def test_spread_width_is_the_mean_of_table_4_8():
    c = [p.value for p in table("4-8").column("c")[3:]]
    assert material("silicone_4mm").spread_width == pytest.approx(np.mean(c) * 1e-3, abs=5e-6)


def test_population_has_the_mean_and_the_spread():
    skin = material("silicone_4mm")
    k1 = np.array([m.dispersion.k1 for m in population(skin, 4000, seed=1)])
    assert k1.mean() == pytest.approx(9619, rel=0.01) and k1.std() == pytest.approx(skin.unit_to_unit["k1"], rel=0.05)
    assert population("silicone_4mm", 3, seed=7) == population("silicone_4mm", 3, seed=7)


def test_one_specimen_is_no_population():
    with pytest.raises(ModelError, match="one specimen"):
        population("frubber_4mm", 3, seed=1)
    with pytest.raises(ModelError, match="one specimen or more"):
        population("silicone_4mm", 0, seed=1)


def test_unknown_material_lists_the_known():
    with pytest.raises(ModelError, match="known are frubber_4mm, silicone_2mm"):
        material("rubber")


@pytest.mark.parametrize("name", SILICONE)
def test_measured_thicknesses_come_back(name):
    skin, scaled = material(name), silicone(material(name).thickness)
    for p in ("m", *SCALED):
        assert getattr(scaled.model.dispersion, p) == pytest.approx(getattr(skin.model.dispersion, p), rel=1e-9)
    assert scaled.std == pytest.approx(skin.std, rel=1e-9)


def test_between_them_it_is_monotone_and_less_certain():
    h = np.linspace(2e-3, 6e-3, 33)
    k1 = np.array([silicone(x).model.dispersion.k1 for x in h])
    k2 = np.array([silicone(x).model.dispersion.k2 for x in h])
    assert np.all(np.diff(k1) < 0) and np.all(np.diff(k2) > 0)
    between = silicone(3e-3)
    assert between.std["k1"] / between.model.dispersion.k1 > 0.09  # 2 mm: 0.08, 4 mm: 0.10, and the form of the curve


def test_it_does_not_extrapolate_unless_asked():
    with pytest.raises(ModelError, match="extrapolate=True"):
        silicone(8e-3)
    far = silicone(8e-3, extrapolate=True)
    assert far.std["k1"] / far.model.dispersion.k1 > silicone(6e-3).std["k1"] / silicone(6e-3).model.dispersion.k1
    for thickness in (20e-3, np.nan, -1e-3):
        with pytest.raises(ModelError, match="too far"):
            silicone(thickness, extrapolate=True)


@pytest.mark.parametrize(("speed", "rows"), [(0.25e-3, ["1"]), (1e-3, ["2", "3"])])
def test_frubber_force_to_force_is_the_filter_of_table_4_7(speed, rows):
    dt, t = 0.01, np.arange(3000) * 0.01
    force = 3.0 + 2.0 * np.sin(1.3 * t)
    b1, k1, b2, k2 = (np.mean([table("4-7").rows[row][f"{p}_over_m"].value for row in rows]) for p in ("b1", "k1", "b2", "k2"))
    _, expected, _ = lsim(([b1, k1], [1.0, b1 + b2, k1 + k2]), force, t)
    state, filtered = (f := frubber_transmission(speed, dt)).initial(), []
    for value in force:
        state, sensed = f.step(state, np.array([value]))
        filtered.append(sensed[0])
    assert np.array(filtered[2500:]) == pytest.approx(expected[2500:], abs=1e-6)  # both start from a state of their own
    assert 0.7 < f.dispersion.sensed_share < 0.8


def test_frubber_at_other_speeds_is_refused():
    with pytest.raises(ModelError, match=r"0.25 and at 1 mm/s, not at 0.5 mm/s"):
        frubber_transmission(0.5e-3, 0.01)


@pytest.mark.parametrize("name", SILICONE)
def test_with_its_mass_left_free_it_senses_the_same_and_weighs_too_much(name):
    free, fixed = free_mass(name), material(name)
    assert (free.model.dispersion.b1, free.model.dispersion.k1) == (fixed.model.dispersion.b1, fixed.model.dispersion.k1)
    assert free.model.dispersion.m >= 0.2 and free.std["m"] > 0.0 and free.spread_width == pytest.approx(fixed.spread_width, nan_ok=True)
    with pytest.raises(ModelError, match="left free for"):
        free_mass("frubber_4mm")
