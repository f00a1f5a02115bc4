import numpy as np
import pytest

from skin_models import thesis
from skin_models.errors import SkinError
from skin_models.thesis.averages import comparisons
from skin_models.thesis.printed import Printed

# entry: (printed, recomputed, can rounding of the inputs explain it)
PINNED = {
    ("3-1", "taxel_1 std"): ("0.0266", 0.0266962, True),
    ("3-1", "taxel_4 std"): ("0.620", 0.618082, True),
    ("3-2", "taxel_1 std"): ("4.49", 4.51241, True),
    ("3-2", "taxel_2 std"): ("1.29", 1.28331, True),
    ("3-2", "taxel_3 std"): ("7.39", 7.37784, True),
    ("3-2", "taxel_4 std"): ("1.41", 1.39821, True),
    ("4-4", "2mm b1"): ("1330", 1330.87, False),
    ("4-4", "2mm b1_std"): ("96.0", 96.1158, False),
    ("4-4", "2mm b2"): ("598.0", 597.933, True),
    ("4-4", "4mm b1"): ("939.5", 939.571, True),
    ("4-4", "4mm k1_std"): ("957", 956.137, True),
    ("4-4", "4mm k2_std"): ("336", 336.507, True),
    ("4-4", "6mm m_std"): (".018", 0.0171723, True),
    ("4-4", "6mm b1"): ("248.6", 248.533, True),
    ("4-4", "6mm b1_std"): ("93.1", 93.1937, True),
}


def test_statistics_follow_from_their_data_except_where_pinned():
    found = {(c.table, c.entry): (str(c.printed), c.recomputed, c.within_rounding) for c in comparisons() if not c.agrees}
    assert len(comparisons()) == 69
    assert found.keys() == PINNED.keys()
    for entry, (printed, recomputed, rounding) in PINNED.items():
        assert found[entry][0] == printed and found[entry][2] is rounding, entry
        assert found[entry][1] == pytest.approx(recomputed, rel=1e-5), entry


def test_std_is_that_of_the_population_and_not_of_a_sample():
    runs = [p.value for p in thesis.table("3-1").column("taxel_2", ("1", "2", "3", "4"))]
    printed = thesis.table("3-1").cell("std", "taxel_2")
    assert printed.agrees(np.std(runs)) and not printed.agrees(np.std(runs, ddof=1))


def test_4mm_averages_weigh_every_run_alike():
    means = np.array([p.value for p in thesis.table("4-2").column("m")])
    printed = thesis.table("4-4").cell("4mm", "m")
    assert printed.agrees(np.average(means, weights=[1, 3, 3])) and not printed.agrees(means.mean())


def test_masses_need_a_square_block():
    printed, d = thesis.table("text").cell("mass_2mm", "value"), 9.53e-3
    assert printed.agrees(1190.0 * d**2 * 2e-3 * 1e3) and not printed.agrees(1190.0 * np.pi / 4 * d**2 * 2e-3 * 1e3)


def test_copied_rows_are_named():
    copied = [d for d in thesis.disagreements() if d.table == "4-11"]
    assert [d.entry.split()[0] for d in copied] == ["2.5", "2.7", "2.8", "2.9"]
    assert all(f"{twin} mm silicone" in d.why for d, twin in zip(copied, ("0.20", "0.30", "0.40", "0.50"), strict=True))


def test_text_that_contradicts_a_table_is_named():
    text = {d.entry: (d.printed, d.recomputed) for d in thesis.disagreements() if d.table == "text"}
    assert text == {"experiments at 1 mm/s": ("1 and 2", "2 and 3"), "plunger diameter, mm": ("9.9", "9.53")}


def test_access_is_typed_and_si():
    depth, distance, force = thesis.scan("4-10")
    assert depth.shape == (10,) and distance.shape == (12,) and force.shape == (10, 12)
    assert depth[-1] == pytest.approx(0.99e-3) and distance[2] == pytest.approx(3e-3) and force[-1, 0] == 10.1
    assert thesis.transfer_functions()[0].speed == pytest.approx(0.25e-3)


@pytest.mark.parametrize(("text", "half"), [("1330", 0.5), ("0.620", 0.0005), (".9970", 0.00005), ("96.0", 0.05)])
def test_rounding_is_read_from_the_digits(text, half):
    assert Printed(text).half == pytest.approx(half)


def test_what_is_not_there_is_one_sentence():
    with pytest.raises(SkinError, match="no '9-9'"):
        thesis.table("9-9")
    with pytest.raises(SkinError, match="no number in row"):
        thesis.table("4-9").cell("1.0", "a")
