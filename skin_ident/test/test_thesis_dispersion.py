"""The thesis's identification, repeated on its testbed in simulation: Tables 4-4, 4-5 and 4-7, and its validation."""

import numpy as np
import pytest
from making import SILICONE, G, response, sine

from skin_ident.estimators.dispersion import FREE, fit_dispersion
from skin_ident.estimators.estimate import IDENTIFIABLE, NOT_IDENTIFIABLE
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.estimators.sinusoid import as_sinusoids
from skin_ident.recordings.recording import Recording
from skin_ident.thesis_dispersion import free_masses, speed_exponents
from skin_models.materials import material
from skin_models.sensors.flexiforce import FlexiForce
from skin_models.sensors.load_cell import LoadCell
from skin_models.thesis.tables import estimates

NAMES = ("b1", "k1", "b2", "k2")
ENCODER = 5e-6 / 3  # m: the stage's accuracy of 5 um as three standard deviations


def measured(xva, force, taxel, seed, taxel_sensor, dt=0.01):
    """A session as chapter 3's load cell, FlexiForce, NI 9201 and encoder record it."""
    rng = np.random.default_rng(seed)
    return Recording(
        name=f"trial {seed}",
        t=np.arange(force.size) * dt,
        depth=xva[0] + ENCODER * rng.normal(size=force.size),
        force=LoadCell(noise=2e-3).sensor().measure(force, dt, seed).force,
        taxels=taxel_sensor.sensor().measure(taxel, dt, seed + 1).force[None],
    )


def protocol(case):
    """Four periods of a sine that just reaches the surface, as deep as the tables imply."""
    return sine(n=6400, amplitude=0.95 * case.amplitude, offset=case.amplitude, hz=1 / 16)


@pytest.mark.parametrize("case", free_masses(), ids=lambda c: f"{c.thickness_mm}mm")
def test_fixed_mass_parameters_come_back(case):
    """Table 4-5, three trials on an ideal taxel."""
    truth = SILICONE[case.thickness_mm]
    xva = protocol(case)
    force, taxels = response(xva, truth)
    ideal = FlexiForce(hysteresis=0.0, drift=0.0, noise=3e-3)
    fit = fit_dispersion([measured(xva, force, taxels[0], seed, ideal) for seed in range(3)], truth[0])
    for name, value in zip(NAMES, truth[1:], strict=True):
        whole = truth[1] + truth[3] if name[0] == "b" else truth[2] + truth[4]  # the load cell's own errors are shares of the whole
        assert abs(fit.values[name] - value) < 0.02 * value + 0.003 * whole, name
    assert fit.verdicts["k1"].word == IDENTIFIABLE


@pytest.mark.parametrize("case", free_masses(), ids=lambda c: f"{c.thickness_mm}mm")
def test_free_and_fixed_mass_give_tables_4_4_and_4_5_on_the_same_data(case):
    """Data that hold a constant force of -m g: the free mass carries it, and when it may not, k2 falls by what the thesis prints."""
    free, fixed = (estimates(t, f"{case.thickness_mm}mm") for t in ("4-4", "4-5"))
    x, v, a = sine(n=6400, amplitude=case.amplitude, offset=case.amplitude, hz=1 / 16)
    taxel = free["b1"].value * v + free["k1"].value * x
    force = free["m"].value * (a - G) + taxel + free["b2"].value * v + free["k2"].value * x
    r = Recording("sine", np.arange(x.size) * 0.01, x + 1e-7, force, taxel[None])
    parts, motions, _ = as_sinusoids([r])
    one, other = fit_dispersion(parts, FREE, motions), fit_dispersion(parts, case.known, motions)
    assert one.values["m"] == pytest.approx(free["m"].value, rel=0.05) and one.values["k2"] == pytest.approx(free["k2"].value, rel=0.05)
    assert other.values["k2"] == pytest.approx(fixed["k2"].value, abs=0.06 * (free["k2"].value - fixed["k2"].value))
    assert one.verdicts["m"].word == NOT_IDENTIFIABLE and "not for inertia" in one.verdicts["m"].sentence


def test_the_tables_imply_how_deep_the_thesis_pressed():
    """A = C of 0.25, 0.52 and 0.78 mm: from the surface to 0.5, 1.05 and 1.6 mm, where the validation went to 0.3, 1.0 and 1.5 mm."""
    assert [c.amplitude for c in free_masses()] == pytest.approx([0.251e-3, 0.523e-3, 0.782e-3], rel=0.01)
    assert [c.force for c in free_masses()] == pytest.approx([2.65, 2.08, 1.96], abs=0.01)


def test_table_4_7_scales_with_speed_as_a_response_to_the_path_does():
    for e in speed_exponents():
        assert e.damping == pytest.approx(1.04, abs=0.01) and e.stiffness == pytest.approx(2.24, abs=0.02)
        assert abs(e.shares[1] - e.shares[0]) < 0.06


@pytest.mark.parametrize("thickness", [2, 4, 6])
def test_validation_on_pseudo_random_moves(thickness):
    """Parameters of a sine predict random straight moves of 1 mm/s with a relative mean squared error in the thesis's range."""
    case = {c.thickness_mm: c for c in free_masses()}[thickness]
    truth, rng = SILICONE[thickness], np.random.default_rng(thickness)
    xva = protocol(case)
    force, taxels = response(xva, truth)
    taxel = FlexiForce(hysteresis=0.02, drift=0.03, noise=3e-3)
    fit = fit_dispersion([measured(xva, force, taxels[0], 7, taxel)], truth[0])
    deepest = {2: 0.3e-3, 4: 1.0e-3, 6: 1.5e-3}[thickness]
    knots = np.concatenate([[0.0], rng.uniform(0.05, 1.0, 20) * deepest, [0.0]])
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(knots)) / 1e-3 + 1.0)])
    t = np.arange(int(times[-1] / 0.01)) * 0.01
    x = np.interp(t, times, knots)
    xva = np.array([x, np.gradient(x, 0.01), np.zeros_like(x)])
    _, true = response(xva, truth)
    got = taxel.sensor().measure(true[0], 0.01, 11).force
    simulated = response(xva, (truth[0], *(fit.values[n] for n in NAMES)))[1][0]
    assert np.mean((got - simulated) ** 2) / np.mean(got**2) < 0.0628


def test_frubber_from_force_to_force():
    """Table 4-6's Frubber has no mass, so its transfer function is of order 1; it comes back from a sine."""
    d = material("frubber_4mm").model.dispersion
    xva = sine(n=6400, amplitude=0.5e-3, offset=0.8e-3, hz=0.15)
    force, taxels = response(xva, (0.0, d.b1, d.k1, d.b2, d.k2))
    r = measured(xva, force, taxels[0], 3, FlexiForce(hysteresis=0.0, drift=0.0, noise=1e-3))
    fit = fit_force_to_force([Recording("f", r.t, None, r.force, r.taxels)])
    assert fit.values["share"] == pytest.approx(d.k1 / (d.k1 + d.k2), rel=0.02)
