"""The compiled path gives what the plain numpy path gives, and conserves force by itself."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from skin_models import native
from skin_models.effects.adhesion import Adhesion
from skin_models.effects.spread_shape import SpreadShape
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.layout import A201_AREA, arbitrary, grid, hexagonal, row
from skin_models.materials import material
from skin_models.simulated_skin import Presses, SimulatedSkin
from skin_models.spread.bending import Bent
from skin_models.spread.compiled import CompiledSkin, compiles
from skin_models.spread.contacts import Contacts
from skin_models.spread.field import SpreadField
from skin_models.spread.kernels import Anisotropic, DepthWidth, Gaussian, GeneralisedGaussian, HeavyTail
from skin_models.transmission import Transmission

SILICONE = material("silicone_4mm").model
GAUSSIAN = Gaussian(width=5.25e-3)
KERNELS = [GAUSSIAN, GeneralisedGaussian(width=5e-3, power=4.0), HeavyTail(width=4e-3, power=2.5), DepthWidth(GAUSSIAN, growth=150.0)]
KERNELS += [Anisotropic(GAUSSIAN, ratio=2.0, angle=0.6), Anisotropic(DepthWidth(GAUSSIAN, growth=150.0), ratio=0.6)]

pytestmark = pytest.mark.skipif(not compiles(GAUSSIAN), reason="no C compiler")


def ball(n=900, radius=40e-3):
    i = np.arange(n) + 0.5
    z, angle = 1 - 2 * i / n, np.pi * (1 + 5**0.5) * i
    normals = np.column_stack([np.sqrt(1 - z**2) * np.cos(angle), np.sqrt(1 - z**2) * np.sin(angle), z])
    return arbitrary(radius * normals, normals)


LAYOUTS = [grid(20, 15, 4e-3), hexagonal(9, 9, 6e-3), row(3, 14e-3), grid(1, 1, 9e-3), ball()]
a_contact = st.tuples(st.tuples(*[st.floats(-0.06, 0.06)] * 3), st.floats(0.0, 50.0), st.sampled_from([0.0, 5e-3]), st.floats(0.0, 3e-3))


@pytest.mark.parametrize("kernel", KERNELS, ids=lambda k: type(k).__name__)
@settings(max_examples=50, deadline=None)
@given(layout=st.sampled_from(LAYOUTS), some=st.lists(a_contact, max_size=5), peak=st.one_of(st.none(), st.just(0.7)), flat=st.booleans())
def test_agrees_with_the_field_and_conserves_force(kernel, layout, some, peak, flat):
    at = [(x, y, 0.0 if flat else z) for (x, y, z), *_ in some]
    assume(layout is not LAYOUTS[-1] or all(np.hypot.reduce(p) > 1e-3 for p in at))  # all of a ball is equally near to its centre
    contacts = Contacts(at, [c[1] for c in some], [c[2] for c in some], [c[3] for c in some])
    field = SpreadField(layout, kernel, peak, A201_AREA)
    slow, fast = field.spread(contacts), CompiledSkin(field).step(contacts)
    total = contacts.force.sum()
    # The table interpolates, and a taxel at the very edge of the reach counts for one path and not for the other.
    assert fast.readings == pytest.approx(slow.taxels, abs=5e-6 * total + 1e-12)
    assert fast.readings.sum() + fast.dispersed == pytest.approx(total, rel=1e-9, abs=1e-300)
    assert np.all(fast.readings >= 0.0) and fast.dispersed >= -1e-9 * total


@pytest.mark.parametrize("layout", LAYOUTS[:3] + LAYOUTS[4:], ids=["grid", "hexagonal", "row", "ball"])
def test_moving_contacts_pass_the_transfer_function_alike(layout):
    field = SpreadField(layout, GAUSSIAN, SILICONE.dispersion.sensed_share, A201_AREA)
    filtered = Transmission(SILICONE.dispersion, 1e-3)
    fast, state, rng = CompiledSkin(field, filtered, settled=1e-9), filtered.initial(len(layout)), np.random.default_rng(1)
    start, speed, force = rng.uniform(-30e-3, 30e-3, (4, 3)), rng.normal(0, 0.05, (4, 3)), rng.uniform(1, 5, 4)
    if layout is not LAYOUTS[4]:
        start[:, 2] = speed[:, 2] = 0.0
    for i in range(400):
        contacts = Contacts(start + i * 1e-3 * speed, force * (i < 300))
        state, expected = filtered.step(state, field.spread(contacts).taxels / SILICONE.dispersion.sensed_share)
        got = fast.step(contacts)
        assert got.readings == pytest.approx(expected, abs=5e-5)
        assert got.readings.sum() + got.dispersed == pytest.approx(got.applied, rel=1e-9, abs=1e-9)


def test_only_what_is_touched_is_worked_on_and_it_comes_to_rest():
    field = SpreadField(grid(100, 100, 5e-3), GAUSSIAN, 0.7, A201_AREA)
    skin = CompiledSkin(field, Transmission(SILICONE.dispersion, 0.01))
    skin.step(Contacts([[0, 0, 0]], [5.0]))
    assert 30 < skin.active < 60
    for _ in range(400):
        last = skin.step(Contacts([], []))
    assert skin.active == 0 and np.all(last.readings == 0.0) and last.dispersed == 0.0


def test_reset_puts_it_at_rest():
    skin = CompiledSkin(SpreadField(LAYOUTS[0], GAUSSIAN), Transmission(SILICONE.dispersion, 0.01))
    first = skin.step(Contacts([[0, 0, 0]], [5.0])).readings.copy()
    skin.step(Contacts([[0, 0, 0]], [5.0]))
    skin.reset()
    assert skin.step(Contacts([[0, 0, 0]], [5.0])).readings == pytest.approx(first, abs=0.0)


def test_contacts_far_away_and_many_contacts():
    skin = CompiledSkin(SpreadField(LAYOUTS[0], GAUSSIAN))
    many = Contacts(np.random.default_rng(0).uniform(-0.04, 0.04, (100, 3)) * [1, 1, 0], np.ones(100))
    assert skin.step(many).outside < 30
    far = skin.step(Contacts([[1e9, -1e9, 0]], [2.0]))
    assert far.outside == 1 and far.dispersed == 2.0


@pytest.mark.parametrize("model", [SILICONE, SILICONE.extended(StressRelaxation.typical("skin"))], ids=["filter", "column"])
def test_the_simulated_skin_is_the_same_either_way(model):
    skins = [SimulatedSkin(model, LAYOUTS[0], 0.01, fast=fast) for fast in (False, True)]
    states = [skin.initial() for skin in skins]
    for i in range(150):
        at = np.array([[1e-3 * i * 0.1, 0, 0], [-8e-3, 3e-3, 0]])
        p = Presses(("a", "b"), at, np.array([3.0 + np.sin(i * 0.1), np.nan]), np.array([np.nan, 2e-4]), np.zeros(2))
        results = [skin.step(state, p) for skin, state in zip(skins, states, strict=True)]
        states = [r[0] for r in results]
        slow, fast = (r[1] for r in results)
        assert fast.taxels == pytest.approx(slow.taxels, abs=1e-4) and fast.dispersed == pytest.approx(slow.dispersed, abs=1e-3)


def test_a_skin_that_pulls_does_so_either_way():
    """On the way out it holds on to the plunger: its taxels feel less than nothing, whichever way they are worked out."""
    model = SILICONE.extended(Adhesion(where="skin", pull_sensed=2.0, pull_dispersed=1.0, reach=0.2e-3))
    skins = [SimulatedSkin(model, LAYOUTS[0], 0.01, fast=fast) for fast in (False, True)]
    states, pulled, outside = [skin.initial() for skin in skins], 0, set()
    for depth in np.concatenate([np.linspace(0.0, 1e-3, 50), np.linspace(1e-3, -3e-4, 100)]):
        p = Presses(("a",), np.zeros((1, 3)), np.array([np.nan]), np.array([depth]), np.zeros(1))
        results = [skin.step(state, p) for skin, state in zip(skins, states, strict=True)]
        states, (slow, fast) = [r[0] for r in results], [r[1] for r in results]
        assert fast.truth == pytest.approx(slow.truth, abs=1e-4)
        pulled, outside = pulled + (slow.truth.sum() < -0.1), outside | {slow.outside - fast.outside}
    assert pulled and outside == {0}


@pytest.mark.parametrize("force", [2.0, 0.0])
def test_a_contact_that_no_taxel_is_near_is_counted_either_way(force):
    skins = [SimulatedSkin(SILICONE.extended(StressRelaxation.typical("skin")), LAYOUTS[0], 0.01, fast=fast) for fast in (False, True)]
    p = Presses(("a",), np.array([[9.0, 0.0, 0.0]]), np.array([force]), np.array([np.nan]), np.zeros(1))
    assert [skin.step(skin.initial(), p)[1].outside for skin in skins] == [1, 1]


def test_kernels_without_a_fast_path_say_so():
    assert not compiles(Bent(Anisotropic(GAUSSIAN, ratio=2.0), (SpreadShape(where="skin", flatness=0.3),)))


def test_without_a_compiler_there_is_no_fast_path_but_a_skin(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("CC", "")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(native.tempfile, "gettempdir", lambda: str(tmp_path))
    native.library.cache_clear()
    try:
        assert not compiles(GAUSSIAN)
        skin = SimulatedSkin(SILICONE, LAYOUTS[2], 0.01, fast=True)
        assert skin.step(skin.initial(), Presses())[1].force == 0.0
    finally:
        native.library.cache_clear()
