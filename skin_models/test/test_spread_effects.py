"""Effects of the spread: what their equations say, and that a model under one plunger and a patch of skin under contacts agree."""

from dataclasses import replace
from itertools import permutations

import numpy as np
import pytest

from skin_models.catalogue import effects
from skin_models.effect import Place
from skin_models.effects.anisotropy import Anisotropy
from skin_models.effects.crosstalk import Crosstalk
from skin_models.effects.layout_crosstalk import LayoutCrosstalk
from skin_models.effects.off_centre import OffCentre
from skin_models.effects.spread_depth import SettlingSpreadDepth, SpreadDepth
from skin_models.effects.spread_shape import SpreadShape
from skin_models.effects.spread_width import SpreadWidth
from skin_models.errors import ModelError
from skin_models.layout import A201_AREA, arbitrary, grid, hexagonal, row
from skin_models.live import LiveModel, under_plunger
from skin_models.materials import material
from skin_models.model import Model
from skin_models.model_file import load_model, model_from_dict, model_to_dict, save_model
from skin_models.signals import Sample, motion
from skin_models.simulated_skin import Presses, SimulatedSkin
from skin_models.spread.bending import Bent
from skin_models.spread.compiled import compiles
from skin_models.spread.footprint import Places
from skin_models.spread.kernels import Anisotropic, DepthWidth, Gaussian, GeneralisedGaussian

C = 5.25e-3
SKIN = material("silicone_4mm").model
XY = np.array([[0.0, 0.0], [6e-3, 1e-3], [-5e-3, 4e-3], [-2e-3, -9e-3], [12e-3, 0.0]])
LAYOUT = arbitrary(np.column_stack([XY, np.zeros(5)]), np.tile([0.0, 0.0, 1.0], (5, 1)), 0.25 * A201_AREA)
BENDING = [c.typical(next(iter(c.places))) for c in effects() if Place.SPREAD in c.places.values()]
ALL = (OffCentre(where="rig", dx=1e-3, dy=-5e-4), Anisotropy(where="skin", stretch=0.4, angle=0.7), SpreadWidth(where="skin", wider=0.2),
       SpreadDepth(where="skin", growth=150.0), SettlingSpreadDepth(where="skin", growth=300.0),
       SpreadShape(where="skin", flatness=0.3))  # fmt: skip
R, V = np.meshgrid(np.linspace(-0.02, 0.02, 41), np.linspace(-0.02, 0.02, 41))


def gaussian(xy):
    return np.exp(-np.sum((np.asarray(xy) / C) ** 2, axis=-1))


def model(*bending):
    return Model(SKIN.dispersion, tuple(0.25 * gaussian(XY)), bending, positions=tuple(map(tuple, XY.tolist())), notes=SKIN.notes)


def presses(x, at=(0.0, 0.0)):
    return Presses(("a",), np.array([[*at, 0.0]]), np.array([np.nan]), np.array([x]), np.zeros(1))


def moving():
    t = np.arange(200) * 0.01
    x = 0.5e-3 * (1.0 - np.cos(3.0 * t))
    v = np.diff(x, prepend=0.0) / 0.01
    return motion(t, x, v, np.diff(v, prepend=0.0) / 0.01)


def test_the_catalogue_holds_every_cause_of_the_spread():
    assert {e.cause for e in BENDING} == {"off_centre", "spread_width", "spread_shape", "spread_depth", "anisotropy"}


@pytest.mark.parametrize(
    ("effect", "kernel"),
    [
        (SpreadWidth(where="skin", wider=0.3), Gaussian(width=1.3 * C)),
        (SpreadShape(where="skin", flatness=0.5), GeneralisedGaussian(width=C, power=3.0)),
        (Anisotropy(where="skin", stretch=0.4, angle=0.7), Anisotropic(Gaussian(width=C), ratio=float(np.exp(0.4)), angle=0.7)),
        (SpreadDepth(where="skin", growth=200.0), DepthWidth(Gaussian(width=C), growth=200.0)),
    ],
    ids=lambda thing: type(thing).__name__,
)
def test_each_is_the_kernel_that_it_says(effect, kernel):
    bent, known = Bent(Gaussian(width=C), (effect,)).at_depth(1e-3), kernel.at_depth(1e-3)
    height = Gaussian(width=C).area / known.area if isinstance(effect, SpreadDepth) else 1.0
    assert bent.shape(bent.distance(R, V)) == pytest.approx(height * known.shape(known.distance(R, V)), abs=1e-12)


def test_off_centre_moves_the_kernel():
    found = model(OffCentre(where="rig", dx=2e-3, dy=-1e-3)).simulate(moving())
    plain = model().simulate(moving())
    assert found.taxels[:, 150] / plain.taxels[0, 150] == pytest.approx(gaussian(XY - [2e-3, -1e-3]), rel=1e-9)
    assert np.array_equal(found.force, plain.force)


@pytest.mark.parametrize("bending", [*((e,) for e in BENDING), ALL], ids=lambda b: "+".join(type(e).__name__ for e in b))
def test_a_plunger_on_the_model_and_a_contact_on_the_patch_agree(bending):
    s, one = moving(), model(*bending)
    skin = SimulatedSkin(one, LAYOUT, s.dt)
    state, truth = skin.initial(), []
    for x in s.x:
        state, reading = skin.step(state, presses(x))
        truth.append(reading.truth)
    assert pytest.approx(one.simulate(s).taxels_truth, abs=2e-5) == np.array(truth).T  # N; the kernel is cut off at 1e-6


def test_their_order_in_the_list_does_not_matter():
    first, *others = (model(*order).simulate(moving()).taxels for order in list(permutations(ALL))[::17])
    assert all(np.allclose(first, other, rtol=1e-12) for other in others)


@pytest.mark.parametrize("effect", BENDING, ids=lambda e: type(e).__name__)
def test_trying_one_on_top_of_the_others_is_extending_the_model(effect):
    one, s = model(*(e for e in ALL if e.cause != effect.cause)), moving()
    assert one.bent(one.trace(s), effect).taxels == pytest.approx(one.extended(effect).simulate(s).taxels, rel=1e-12)


def test_a_contact_that_moves_meets_the_taxels_one_after_the_other():
    s, n = moving(), 200
    lateral = np.array([np.linspace(-5e-3, 14e-3, n), np.full(n, 1e-3)])
    one = model(*ALL)
    whole, state, patch = one.simulate(replace(s, lateral=lateral)), one.initial(), SimulatedSkin(one, LAYOUT, s.dt)
    patch_state = patch.initial()
    for i in range(n):
        sample = Sample(s.t[i], s.x[i], s.v[i], s.a[i], lateral[:, i])
        state, response = one.step(state, sample, s.dt)
        assert response.taxels == pytest.approx(whole.taxels[:, i], rel=1e-12, abs=1e-12)
        patch_state, reading = patch.step(patch_state, presses(s.x[i], lateral[:, i]))
        assert reading.truth == pytest.approx(whole.taxels[:, i], abs=2e-5)
    assert np.argmax(whole.taxels[:, 60]) == 0 and np.argmax(whole.taxels[:, 165]) == 4


def test_a_taxel_far_from_the_place_of_the_shares_is_taken_to_be_like_the_others():
    far = Model(SKIN.dispersion, (0.8, 0.0), positions=((0.0, 0.0), (0.5, 0.0)))
    s = moving()
    over = far.simulate(replace(s, lateral=np.tile([[0.5], [0.0]], 200))).taxels
    assert over[1] == pytest.approx(far.simulate(s).taxels[0]) and not over[0].any()


@pytest.mark.parametrize("bending", [*((e,) for e in BENDING), ALL], ids=lambda b: "+".join(type(e).__name__ for e in b))
def test_force_is_conserved_with_the_spread_bent(bending):
    skin = SimulatedSkin(model(*bending), grid(16, 16, 4e-3), 0.01)
    state = skin.initial()
    for i in range(100):
        state, reading = skin.step(state, presses(1e-3, (5e-5 * i, 0.0)))
    assert reading.truth.sum() + reading.dispersed == pytest.approx(reading.force, rel=1e-9)
    assert np.all(reading.truth >= 0.0) and reading.dispersed > -0.01  # N: the skin's own weight


@pytest.mark.parametrize("bending", [*((e,) for e in BENDING), ALL], ids=lambda b: "+".join(type(e).__name__ for e in b))
def test_beyond_the_reach_there_is_nothing(bending):
    bent = Bent(Gaussian(width=C), bending).at_depth(1e-3)
    angle, tolerance = np.linspace(0.0, 2.0 * np.pi, 73), 1e-4
    at_the_end = bent.reach(tolerance) * np.array([np.cos(angle), np.sin(angle)])
    assert bent.shape(bent.distance(*at_the_end)).max() <= tolerance * 1.001


def test_the_compiled_path_is_taken_where_it_can_and_agrees():
    bent = model(*ALL)
    if not compiles(Gaussian(width=C)):
        pytest.skip("no C compiler here")
    dense, fast = (SimulatedSkin(bent, grid(12, 12, 4e-3), 0.01, fast=fast) for fast in (False, True))
    assert compiles(fast.kernel) and not compiles(Bent(Anisotropic(Gaussian(width=C), ratio=1.2), ALL))
    at, force, depth = np.array([[1e-3, 2e-3, 0.0], [-9e-3, 0.0, 0.0]]), np.array([np.nan, 4.0]), np.array([1e-3, np.nan])
    two = Presses(("a", "b"), at, force, depth, np.zeros(2))
    slow, quick = (skin.step(skin.initial(), two)[1] for skin in (dense, fast))
    assert quick.truth == pytest.approx(slow.truth, abs=5e-5) and slow.truth.max() > 1.0


def test_on_curved_skin_off_centre_goes_along_the_surface():
    i = np.arange(900) + 0.5
    z, angle = 1.0 - 2.0 * i / 900, np.pi * (1.0 + 5.0**0.5) * i
    normals = np.column_stack([np.sqrt(1.0 - z**2) * np.cos(angle), np.sqrt(1.0 - z**2) * np.sin(angle), z])
    ball = arbitrary(30e-3 * normals, normals)
    at = np.array([[0.0, 0.0, 30e-3], [0.0, 30e-3, 0.0]])  # along x on top, and on the side as well
    where = [SimulatedSkin(SKIN.extended(OffCentre(where="rig", dx=d, dy=0.0)), ball, 0.01) for d in (0.0, 4e-3)]
    for place in at:
        felt = [s.step(s.initial(), Presses.of_forces([place], [5.0]))[1].truth for s in where]
        centres = [truth @ ball.positions / truth.sum() for truth in felt]
        assert centres[1] - centres[0] == pytest.approx([4e-3, 0.0, 0.0], abs=0.8e-3)


def test_a_contact_of_known_force_is_as_deep_as_the_force_holds():
    force = 8.0
    depth = force / (SKIN.dispersion.k1 + SKIN.dispersion.k2)
    skin = SimulatedSkin(model(SpreadDepth(where="skin", growth=800.0)), LAYOUT, 0.01)
    by_force = Presses(("a",), np.zeros((1, 3)), np.array([force]), np.array([np.nan]), np.zeros(1))
    readings = []
    for p in (by_force, presses(depth)):
        state = skin.initial()
        for _ in range(400):
            state, reading = skin.step(state, p)
        readings.append(reading.truth)
    assert readings[0] == pytest.approx(readings[1], rel=1e-3)


def test_without_positions_it_is_said_what_is_missing():
    for effect in (*BENDING, LayoutCrosstalk.typical("taxel")):
        with pytest.raises(ModelError, match="positions, or a layout"):
            replace(model(effect), positions=()).simulate(moving())
    with pytest.raises(ModelError, match="moves across the skin"):
        SKIN.step(SKIN.initial(), Sample(0.0, 1e-3, 0.0, 0.0, np.zeros(2)), 0.01)
    for wrong in (((0.0, 0.0),), ((0.0, np.nan),) * 5, ((0.0, 0.0, 0.0),) * 5):
        with pytest.raises(ModelError, match="positions"):
            replace(model(), positions=wrong)


def test_positions_are_kept_in_the_model_file(tmp_path):
    save_model(model(*ALL), tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml") == model(*ALL)
    content = model_to_dict(model())
    for wrong in ([[0.0, 0.0]] * 5, {"value": [[0.0, 0.0]] * 5, "unit": "mm"}, {"value": [[0.0]] * 5, "unit": "m"}, None):
        with pytest.raises(ModelError, match=r"positions must be written"):
            model_from_dict({**content, "positions": wrong})


def test_a_live_model_under_a_plunger_knows_where_its_taxels_are():
    layout = row(3, 7e-3)
    one = under_plunger(SKIN.extended(OffCentre(where="rig", dx=1e-3, dy=0.0)), layout, Gaussian(width=C))
    taxels = LiveModel(one).step(0.0, 1e-3).taxels
    expected = gaussian(layout.positions[:, :2] - [1e-3, 0.0])
    assert taxels / taxels.max() == pytest.approx(expected / expected.max(), rel=1e-6)
    measured = under_plunger(Model(SKIN.dispersion, (0.3, 1.0, 0.2)), layout, Gaussian(width=C))
    assert measured.shares == (0.3, 1.0, 0.2) and len(measured.positions) == 3


def test_crosstalk_of_a_layout_takes_the_nearest_taxels():
    y = np.arange(9.0) ** 2
    for places, neighbours in ((grid(3, 3, 5e-3), [1, 3, 5, 7]), (hexagonal(3, 3, 5e-3), [1, 2, 3, 5, 7, 8])):
        mean = (Places(places.positions).neighbours @ y)[4]
        assert mean == pytest.approx(y[neighbours].mean())
    assert not (Places(np.zeros((1, 2))).neighbours @ np.ones(1)).any()
    line = replace(model(), positions=tuple((5e-3 * i, 0.0) for i in range(5)))
    by_layout, by_row = (line.extended(c(where="taxel", share=0.2)).simulate(moving()).taxels for c in (LayoutCrosstalk, Crosstalk))
    assert by_layout == pytest.approx(by_row, rel=1e-12)
    skin = SimulatedSkin(model(LayoutCrosstalk(where="taxel", share=0.2)), grid(3, 3, 5e-3), 0.01)
    reading = skin.step(skin.initial(), presses(1e-3))[1]
    assert reading.taxels[4] - reading.truth[4] == pytest.approx(0.2 * reading.truth[[1, 3, 5, 7]].mean())
