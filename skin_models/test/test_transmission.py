import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.signal import lsim, lti

from skin_models.dispersion import Dispersion
from skin_models.errors import ModelError
from skin_models.materials import material
from skin_models.thesis.tables import transfer_functions
from skin_models.transmission import Transmission


def plain(**values):
    return Dispersion(**{"b1": 0.0, "k1": 0.0, "b2": 0.0, "k2": 0.0, **values})


SILICONE = material("silicone_4mm").model.dispersion
FRUBBER = [Dispersion(m=1.0, b1=t.b1, k1=t.k1, b2=t.b2, k2=t.k2) for t in transfer_functions()]  # Table 4-7: over the mass
ALL = [SILICONE, Dispersion(m=0.0, b1=243.0, k1=1523.0, b2=243.0, k2=481.0), plain(k1=3.0, k2=1.0), *FRUBBER]


def run(d, dt, force):
    f = Transmission(d, dt)
    state, out = f.initial(), []
    for u in force:
        state, y = f.step(state, np.array([u]))
        out.append(y[0])
    return np.array(out)


@pytest.mark.parametrize("d", ALL, ids=lambda d: f"m={d.m:g},k1={d.k1:g}")
def test_static_share_is_k1_over_k1_plus_k2(d):
    assert run(d, 0.5, np.ones(400))[-1] == pytest.approx(d.sensed_share, rel=1e-9)


@pytest.mark.parametrize("d", FRUBBER)
def test_agrees_with_the_transfer_function_of_eq_32(d):
    t = np.linspace(0, 8, 801)
    force = np.interp(t, [0, 1, 1.5, 3, 8], [0, 4, 1, 3, 0])  # piecewise linear: the hold is exact
    system = lti([d.b1, d.k1], [d.m, d.b1 + d.b2, d.k1 + d.k2])
    assert run(d, t[1], force) == pytest.approx(lsim(system, force, t)[1], abs=1e-9)


def test_light_skin_agrees_with_the_stiff_differential_equation():
    d, t = SILICONE, np.linspace(0, 1, 101)
    force = np.interp(t, [0, 0.2, 0.5, 1.0], [0, 5, 5, 1])
    b, k = d.b1 + d.b2, d.k1 + d.k2

    def rate(time, z):
        return [z[1], (np.interp(time, t, force) - b * z[1] - k * z[0]) / d.m]

    z = solve_ivp(rate, (0, 1), [0, 0], method="Radau", t_eval=t, rtol=1e-9, atol=1e-12, max_step=0.01).y
    assert run(d, 0.01, force) == pytest.approx(d.b1 * z[1] + d.k1 * z[0], abs=2e-4)


@pytest.mark.parametrize("d", ALL, ids=lambda d: f"m={d.m:g},k1={d.k1:g}")
def test_a_linear_force_gives_the_same_at_any_sample_rate(d):
    coarse, fine = run(d, 0.1, np.arange(50) * 0.1), run(d, 0.01, np.arange(491) * 0.01)
    assert coarse == pytest.approx(fine[::10], rel=1e-6, abs=1e-9)


def test_channels_are_independent():
    f = Transmission(SILICONE, 0.01)
    state, y = f.step(f.initial(3), np.array([1.0, 0.0, 2.0]))
    assert state.shape == (2, 3) and y[1] == 0.0 and y[2] == pytest.approx(2 * y[0])


@pytest.mark.parametrize("d", [plain(), plain(k1=1.0, b1=-2.0), plain(m=1.0, k1=1.0), plain(k1=1.0, k2=-1.0, b1=1.0)])
def test_what_does_not_settle_is_refused(d):
    with pytest.raises(ModelError, match="never settles"):
        Transmission(d, 0.01)
    with pytest.raises(ModelError, match="period"):
        Transmission(SILICONE, 0.0)
