"""What every effect of the catalogue promises, checked on all of them: a new effect is tested by being there."""

import copy
import inspect
import math
from dataclasses import replace

import numpy as np
import pytest

from skin_models.catalogue import effect_class, effects
from skin_models.dispersion import Dispersion
from skin_models.effect import Place
from skin_models.errors import ModelError
from skin_models.model import Model
from skin_models.model_file import load_model, model_from_dict, model_to_dict, save_model
from skin_models.operators.tree import mapped
from skin_models.parameter import AMPLITUDE, SHAPE, parameters_of, scan_of
from skin_models.signals import Motion, Sample, motion
from skin_models.spread.footprint import Footprint, Places
from skin_models.spread.kernels import Gaussian

CAUSES = """nonlinear_stiffness stress_relaxation rate_dependence hysteresis cyclic_softening adhesion dead_zone friction position_offset
    mount_compliance backlash off_centre inertia gain_error force_offset drift saturation quantization lag time_shift crosstalk
    interference outliers dead_taxel noise nonlinearity spread_width spread_shape spread_depth anisotropy"""
RANDOM = {"Noise", "Outliers", "RandomWalk", "TimeJitter"}  # no limit as the step shrinks: see test_random_effects.py
POSITIONS = ((-6e-3, 2e-3), (0.0, 0.0), (5e-3, -3e-3))  # m, of the three taxels
IN_JUMPS = {  # parameters that move the output in jumps: no derivative to speak of
    ("SensorQuantization", "step_force"), ("GatedTaxel", "threshold"), ("GainStep", "after"), ("Outliers", "rate"),
}  # fmt: skip

CASES = [(c, w) for c in effects() for word in c.places for w in ((word, "taxel_1") if word == "taxel" else (word,))]


def where_it_holds(chosen):
    """The test runs for every effect and place that `chosen` takes."""
    cases = [pytest.param(c, w, id=f"{c.__name__}-{w}") for c, w in CASES if chosen(c, w)]
    return pytest.mark.parametrize(("cls", "where"), cases)


every_effect = where_it_holds(lambda c, w: True)


def path(dt: float = 2e-3, end: float = 14.0) -> Motion:
    """Presses of growing depth with minor loops, a hold and free air, known in closed form."""
    t = np.arange(round(end / dt) + 1) * dt
    w = 2.0 * np.pi * np.array([0.31, 1.13])
    size = np.array([0.9e-3, 0.25e-3])
    waves, rates = np.sin(np.outer(w, t)), np.cos(np.outer(w, t))
    x = 0.6e-3 + size @ waves + 0.02e-3 * t
    return laid(Motion(t, x, (size * w) @ rates + 0.02e-3, -(size * w**2) @ waves, dt))


def laid(s: Motion) -> Motion:
    """The motion over three taxels."""
    places = Places(np.array(POSITIONS))
    return replace(s, footprint=Footprint(places, places.positions.T, Gaussian(width=5.25e-3)))


def signal(place: Place, s: Motion) -> np.ndarray:
    """A smooth signal such as passes that place."""
    spring = 8e3 * np.maximum(s.x, 0.0)
    if place is Place.DEPTH:
        return s.x.copy()
    if place in (Place.SKIN, Place.SURFACE):
        return np.array([spring, 0.4 * spring])
    if place is Place.LOAD_CELL:
        return 1.4 * spring
    shares = np.array([0.3, 1.0, 0.2])[:, None]
    return shares * (spring if place is Place.TAXEL else np.ones(len(s)))


def typical(cls: type, where: str, dt: float = 2e-3) -> tuple:
    s = path(dt)
    e = cls.typical(where)
    return e, signal(e.place, s), s


def run(e, y, s, seed=7):
    return e.batch(y, s, None if seed is None else np.random.default_rng(seed))


def steps(e, y, s, seed=7):
    state, out = e.initial(np.random.default_rng(seed)), []
    for i in range(len(s)):
        state, o = e.step(state, y[..., i], s[i], s.dt)
        out.append(o)
    return np.stack(out, axis=-1)


@every_effect
def test_it_is_finite_and_leaves_its_input_alone(cls, where):
    e, y, s = typical(cls, where)
    before = y.copy()
    out = run(e, y, s)
    assert out.shape == y.shape and np.all(np.isfinite(out))
    assert np.array_equal(y, before)
    assert not np.array_equal(out, y), "an ordinary size does nothing on this path"


@every_effect
def test_stepping_equals_batch_to_rounding(cls, where):
    e, y, s = typical(cls, where, dt=5e-3)
    assert np.max(np.abs(steps(e, y, s) - run(e, y, s))) <= 1e-12 * max(1.0, np.max(np.abs(y)))


@every_effect
def test_one_sample_is_enough(cls, where):
    s = laid(Motion(np.zeros(1), np.full(1, 1e-3), np.zeros(1), np.zeros(1), 5e-3))
    e = cls.typical(where)
    y = signal(e.place, s)
    out = run(e, y, s)
    assert out.shape == y.shape and np.max(np.abs(out - steps(e, y, s))) <= 1e-12 * max(1.0, np.max(np.abs(y)))


@every_effect
def test_a_step_can_be_tried_and_taken_back(cls, where):
    e, y, s = typical(cls, where)
    state = e.initial(np.random.default_rng(7))
    for i in range(80):
        kept, fed = copy.deepcopy(state), np.array(y[..., i])
        after, first = e.step(state, fed, s[i], s.dt)
        assert repr(state) == repr(kept) and np.array_equal(fed, y[..., i])
        assert np.array_equal(e.step(state, fed, s[i], s.dt)[1], first)
        state = after


@every_effect
def test_size_zero_is_the_identity(cls, where):
    e, y, s = typical(cls, where, dt=5e-3)
    absent = e.absent()
    assert np.array_equal(run(absent, y, s), y)
    assert np.array_equal(steps(absent, y, s), y)
    assert np.array_equal(run(e, y, s, seed=None), y) or cls.__name__ not in RANDOM


@where_it_holds(lambda c, w: c.__name__ not in RANDOM)
def test_it_converges_as_the_step_shrinks(cls, where):
    e, errors = cls.typical(where), []
    finest, every = path(0.5e-3), 8
    limit = run(e, signal(e.place, finest), finest)[..., ::every]
    for dt in (4e-3, 2e-3, 1e-3):
        s = path(dt)
        error = run(e, signal(e.place, s), s)[..., :: round(4e-3 / dt)] - limit
        errors.append(np.sqrt(np.mean(error**2)))
    size = np.sqrt(np.mean(limit**2))
    assert errors[0] <= 0.01 * size, "a step of 4 ms is far off"
    assert errors[2] <= 1e-9 * size or errors[2] <= 0.45 * errors[0], errors


@every_effect
def test_its_jacobian_is_finite_and_smooth(cls, where):
    e, y, s = typical(cls, where)
    for p in parameters_of(e):
        if (cls.__name__, p.name) in IN_JUMPS:
            continue
        coarse, fine = (_slope(e, p, y, s, share) for share in (2e-4, 5e-5))
        assert np.all(np.isfinite(fine))
        assert _norm(fine - coarse) <= 0.1 * _norm(fine) + 1e-9 * _norm(y) / abs(p.value or 1.0), p.name


@every_effect
def test_what_a_motion_remembers_of_it_is_of_its_present_numbers(cls, where):
    e, y, s = typical(cls, where)
    run(e, y, s)
    for p in parameters_of(e):
        other = e.with_values(**{p.name: min(1.1 * p.value, p.upper)})
        assert np.array_equal(run(other, y, s), run(other, y, path())), p.name


def _slope(e, p, y, s, share):
    h = share * abs(p.value or 1.0)
    low, high = max(p.value - h, p.lower), min(p.value + h, p.upper)
    return (run(e.with_values(**{p.name: high}), y, s) - run(e.with_values(**{p.name: low}), y, s)) / (high - low)


def _norm(a):
    return float(np.sqrt(np.mean(np.square(a))))


@where_it_holds(lambda c, w: c.linear)
def test_its_regressors_add_up_to_it(cls, where):
    e, y, s = typical(cls, where)
    parts = e.regressors(y, s)
    amplitudes = {p.name: p.value for p in parameters_of(e) if p.role == AMPLITUDE}
    assert parts.keys() == amplitudes.keys()
    half = e.with_values(**{name: 0.5 * value for name, value in amplitudes.items()})
    for share, effect in ((1.0, e), (0.5, half)):
        whole = y + share * sum(amplitudes[name] * parts[name] for name in parts)
        assert np.max(np.abs(run(effect, y, s) - whole)) <= 1e-12 * max(1.0, np.max(np.abs(y)))


@where_it_holds(lambda c, w: not c.linear)
def test_it_says_that_it_has_no_regressors(cls, where):
    e, y, s = typical(cls, where)
    with pytest.raises(ModelError, match="not linear"):
        e.regressors(y, s)


@every_effect
def test_parameters_are_declared_and_their_bounds_enforced(cls, where):
    e = cls.typical(where)
    for p in parameters_of(e):
        assert p.unit and p.doc and p.lower <= p.value <= p.upper and not math.isnan(p.typical)
        assert all(p.lower <= point <= p.upper for point in scan_of(cls, p.name))
        for bound, outside in ((p.lower, math.nextafter(p.lower, -math.inf)), (p.upper, math.nextafter(p.upper, math.inf))):
            if math.isfinite(bound):
                e.with_values(**{p.name: bound})
                with pytest.raises(ModelError, match=p.name):
                    e.with_values(**{p.name: outside})
        assert e.with_values(**{p.name: np.float32(p.value)}).values[p.name] == np.float32(p.value)
        for nonsense in (math.nan, "1", None, True, -math.inf):
            with pytest.raises(ModelError, match=p.name):
                e.with_values(**{p.name: nonsense})
    for nowhere in ("moon", "taxel_²", "taxel_-1"):
        with pytest.raises(ModelError, match="cannot sit in"):
            cls.typical(nowhere)
    with pytest.raises(ModelError, match="needs a place"):
        cls.typical(None)


@every_effect
def test_its_proposals_can_be_built(cls, where):
    shapes = list(cls.shapes(path()))
    names = {p.name for p in parameters_of(cls) if p.role == SHAPE}
    assert bool(shapes) == cls.proposed and all(set(shape) == names for shape in shapes)
    for shape in shapes:
        assert cls.typical(where, **shape).values.items() >= shape.items()


@every_effect
def test_it_survives_a_model_file(cls, where, tmp_path):
    e = cls.typical(where)
    skin = Dispersion(b1=900.0, k1=9600.0, b2=600.0, k2=2700.0)
    model = Model(skin, shares=(0.3, 1.0, 0.2), effects=(e, e.absent()), positions=POSITIONS)
    save_model(model, tmp_path / "model.yaml")
    assert load_model(tmp_path / "model.yaml") == model


@every_effect
def test_its_name_place_and_source_are_stated(cls, where):
    assert cls.cause in CAUSES.split() and cls.source and inspect.getdoc(cls) and "=" in inspect.getmodule(cls).__doc__
    assert [c for c in effects() if (c.cause, c.form) == (cls.cause, cls.form) and set(c.places) & set(cls.places)] == [cls]
    assert effect_class(cls.cause, where, cls.form) is cls
    assert any(p.role == AMPLITUDE for p in parameters_of(cls))


@where_it_holds(lambda c, w: w == "taxel_1")
def test_on_one_taxel_it_leaves_the_others_alone(cls, where):
    e, y, s = typical(cls, where, dt=5e-3)
    for out in (run(e, y, s), steps(e, y, s)):
        assert np.array_equal(out[[0, 2]], y[[0, 2]]) and not np.array_equal(out[1], y[1])


@where_it_holds(lambda c, w: c.places.get(w) is Place.SKIN)
def test_in_the_skin_it_is_silent_in_the_air(cls, where):
    e, y, s = typical(cls, where)
    air = s.x <= 0.0
    assert air.any() and not np.any(run(e, y, s)[:, air])


@where_it_holds(lambda c, w: c.places.get(w) in (Place.SKIN, Place.SURFACE))
def test_in_the_skin_it_steps_many_contacts_at_once(cls, where):
    e, y, s = typical(cls, where, dt=2e-2)
    shifts, together, one_by_one = (0, 30, 110), e.initial(), [e.initial() for _ in range(3)]
    for i in range(300):
        samples, signals = [s[i + d] for d in shifts], [y[:, i + d] for d in shifts]
        whole = Sample(*(np.array(column) for column in zip(*((o.t, o.x, o.v, o.a) for o in samples), strict=True)))
        together, out = e.step(together, np.array(signals).T, whole, s.dt)
        for k in range(3):
            one_by_one[k], alone = e.step(one_by_one[k], signals[k], samples[k], s.dt)
            assert np.allclose(out[:, k], alone, rtol=1e-12, atol=1e-12)
        assert mapped(lambda a: np.shape(a)[-1], together) == mapped(lambda a: 3, together)


@every_effect
def test_absurd_motion_stays_finite(cls, where):
    e = cls.typical(where)
    t = np.arange(400) * 1e-3
    for x in (np.zeros(400), np.full(400, 0.03), np.where(t < 0.2, 0.0, 0.03), -0.03 * t):
        s = laid(motion(t + 1.7e9, x))
        out = run(e, signal(e.place, s), s)
        assert np.all(np.isfinite(out))


@every_effect
def test_a_model_with_it_steps_as_it_simulates(cls, where):
    skin = Dispersion(m=4e-4, b1=900.0, k1=9600.0, b2=600.0, k2=2700.0)
    model, s = Model(skin, shares=(0.3, 1.0, 0.2), effects=(cls.typical(where),), positions=POSITIONS), path(dt=1e-2)
    whole, state = model.simulate(s, seed=5), model.initial(seed=5)
    for i in range(len(s)):
        state, one = model.step(state, s[i], s.dt)
        assert one.force == pytest.approx(whole.force[i], rel=1e-9, abs=1e-9)
        assert one.taxels == pytest.approx(whole.taxels[:, i], rel=1e-9, abs=1e-9)


def test_an_unknown_cause_place_or_form_is_named_with_what_there_is():
    for wrong in (("lag", "moon"), ("lag", "taxel", "third_order")):
        with pytest.raises(ModelError, match=r"no effect models .* known: lag \(taxel, load_cell\); lag of the form averaged"):
            effect_class(*wrong)
    with pytest.raises(ModelError, match=r"no effect models 'magic' in 'skin'; known: adhesion, anisotropy, .*time_shift$"):
        effect_class("magic", "skin")
    content = {"cause": "rate_dependence", "where": "skin", "form": "cubic", "parameters": {}}
    with pytest.raises(ModelError, match="cubic"):
        model_from_dict({**model_to_dict(Model(Dispersion(b1=9.0, k1=96.0, b2=6.0, k2=27.0))), "effects": [content]})


def test_a_model_tells_its_effects_by_cause_and_place():
    lags = [effect_class("lag", "taxel").typical(where) for where in ("taxel", "taxel_1", "taxel")]
    drift = effect_class("drift", "taxel").typical("taxel_1")
    model = Model(Dispersion(b1=9.0, k1=96.0, b2=6.0, k2=27.0), shares=(0.3, 1.0), effects=(*lags, drift), name="mine")
    assert [e.key for e in model.effects] == [("lag", "taxel"), ("lag", "taxel_1"), ("lag", "taxel"), ("drift", "taxel_1")]
    assert model.having(("lag", "taxel")) == (lags[0], lags[2]) and model.having(("drift", "taxel")) == ()
    assert model.lacking(("lag", "taxel")) == replace(model, effects=(lags[1], drift))
    assert model.lacking(("lag", "taxel"), ("lag", "taxel_1"), ("drift", "skin")).effects == (drift,)
    assert model.lacking() == model and "key" not in model_to_dict(model)["effects"][0]
