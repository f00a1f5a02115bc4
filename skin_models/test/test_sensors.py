"""Sensor chains of chapter 3: the thesis's numbers come out, units stay within their data sheets, the truth lies beside."""

import numpy as np
import pytest

from skin_models.dispersion import Dispersion
from skin_models.errors import ModelError
from skin_models.model import Model
from skin_models.model_file import load_model, save_model
from skin_models.sensors import NI9201, Adc, FlexiForce, LoadCell, TaxelBank
from skin_models.sensors.flexiforce import MIDDLE_SLOPE
from skin_models.sensors.load_cell import CAPACITY
from skin_models.signals import motion
from skin_models.thesis.tables import table

DT = 1e-3
CYCLES = CAPACITY * 0.5 * (1.0 - np.cos(2.0 * np.pi * 0.5 * np.arange(0.0, 8.0, DT)))  # four full cycles of 2 s


def test_slopes_and_steps_are_those_of_the_thesis():
    cell = LoadCell().sensor()
    assert cell.slope == pytest.approx(25 / 8 * 4.44822)  # eq 25
    assert pytest.approx(4.88e-3, abs=5e-6) == NI9201.code_width
    assert NI9201.code_width * cell.slope == pytest.approx(0.07, abs=0.003)
    reading = cell.measure(np.full(50, 10.0), DT)
    assert reading.volts * 25 / 8 * 4.44822 == pytest.approx(reading.force)  # eq 25
    taxel = FlexiForce(slope=9.413).sensor().measure(np.full(50, 10.0), DT)
    assert taxel.volts * 9.413 == pytest.approx(taxel.force)  # eq 26
    codes = reading.volts / NI9201.code_width
    assert codes == pytest.approx(np.round(codes))


def test_the_middle_slope_is_that_of_table_3_1():
    slopes = [cell.value for run, row in table("3-1").rows.items() if run.isdigit() for cell in row.values()]
    assert len(slopes) == 16 and np.mean(slopes) == pytest.approx(MIDDLE_SLOPE, abs=0.01)


@pytest.mark.parametrize(("unit", "limit"), [(LoadCell, 0.01 + 0.001 + 0.001 + 0.0005), (FlexiForce, 0.025 + 0.03 + 0.045 + 0.05)])
def test_units_stay_within_the_sum_of_their_data_sheet(unit, limit):
    worst = []
    for seed in range(40):
        sensor = unit.drawn(np.random.default_rng(seed)).sensor("taxel")
        reading = sensor.measure(0.4 * CYCLES, DT)
        step = NI9201.code_width * sensor.slope
        worst.append((np.abs(reading.force - reading.truth).max() - step) / CAPACITY)
    assert max(worst) <= limit and max(worst) > 0.1 * limit


def test_hysteresis_of_a_full_cycle_is_as_wide_as_stated():
    taxel = FlexiForce(slope=25.0, nonlinearity=0.0, hysteresis=0.045, drift=0.0)  # no clipping below 125 N
    force = taxel.sensor(adc=Adc(bits=24, volts=10.0)).measure(CYCLES, DT).force
    up, down = force[-1999:-1000], force[:-1000:-1]  # one sample after the start, one before the end: at the same truth
    assert np.max(down - up) / CAPACITY == pytest.approx(0.045, rel=0.001)


def test_the_filter_is_3_db_down_at_its_bandwidth():
    dt, cutoff = 1e-5, 2200.0
    wave = np.sin(2.0 * np.pi * cutoff * np.arange(4000) * dt)
    sensor = LoadCell(nonlinearity=0.0, hysteresis=0.0).sensor(adc=Adc(bits=30, volts=10.0))
    assert sensor.measure(wave, dt).force[2000:].max() == pytest.approx(np.sqrt(0.5), abs=0.01)


def test_a_taxel_clips_at_five_volts_and_reads_wrongly_uncalibrated():
    taxel = FlexiForce(slope=9.4, drift=0.0, hysteresis=0.0)
    reading = taxel.sensor().measure(CYCLES, DT)
    assert reading.volts.max() == pytest.approx(5.0, abs=NI9201.code_width) and reading.truth.max() > 100.0
    low = np.full(50, 20.0)
    raw = taxel.uncalibrated().sensor().measure(low, DT)
    assert raw.volts == pytest.approx(taxel.sensor().measure(low, DT).volts, abs=NI9201.code_width)
    assert raw.force == pytest.approx(20.0 * MIDDLE_SLOPE / 9.4, abs=0.1)


def test_sensors_plug_into_a_model_and_its_file(tmp_path):
    rng = np.random.default_rng(0)
    chain = (
        *LoadCell.drawn(rng, noise=2e-3).sensor().effects,
        *FlexiForce.drawn(rng, noise=2e-3).sensor("taxel_0").effects,
        *FlexiForce.drawn(rng, noise=2e-3).sensor().at("taxel_1").effects,
    )
    model = Model(Dispersion(b1=900.0, k1=9600.0, b2=600.0, k2=2700.0), shares=(1.0, 0.4), effects=chain)
    save_model(model, tmp_path / "model.yaml")
    assert load_model(tmp_path / "model.yaml") == model
    t = np.arange(3000) * DT
    out = model.simulate(motion(t, 0.8e-3 * (1 - np.cos(2 * t))), seed=1)
    assert not np.array_equal(out.force, out.force_truth) and np.abs(out.force - out.force_truth).max() < 0.03 * CAPACITY
    assert out.taxels.shape == out.taxels_truth.shape == (2, 3000)


def test_a_bank_spreads_its_gains_and_counts_its_dead():
    bank = TaxelBank(count=5000, seed=3, gain_spread=0.2, bias_spread=0.1, dead=0.02)
    assert (bank.gains == 0.0).mean() == pytest.approx(0.02, abs=0.006)
    assert np.log(bank.gains[bank.gains > 0.0]).std() == pytest.approx(0.2, rel=0.05)
    _, y = bank.step(bank.initial(), np.full(5000, 3.0), DT)
    assert y == pytest.approx(3.0 * bank.gains + bank.biases)
    assert np.array_equal(TaxelBank(count=5000, seed=3, gain_spread=0.2, dead=0.02).gains, bank.gains)


def test_a_bank_walks_and_is_late():
    bank = TaxelBank(count=2000, walk=0.1, delay=0.005)
    state = bank.initial()
    for i in range(101):
        state, y = bank.step(state, np.full(2000, float(i >= 50)), 0.01)
        if i == 50:
            assert y.mean() == pytest.approx(0.5, abs=0.02)  # half a period late
    assert y.std() == pytest.approx(0.1, rel=0.1)


def test_a_plain_bank_says_the_truth():
    bank, state = TaxelBank(count=3), TaxelBank(count=3).initial()
    for force in ([0.0, 1.0, 2.0], [3.0, -1.0, 0.0]):
        state, y = bank.step(state, np.array(force), DT)
        assert np.array_equal(y, force)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Adc(bits=0, volts=10.0),
        lambda: Adc(bits=12, volts=-1.0),
        lambda: LoadCell(zero=2.0),
        lambda: FlexiForce(slope=0.0),
        lambda: TaxelBank(count=0),
        lambda: TaxelBank(count=3, dead=1.5),
        lambda: LoadCell().sensor().measure(np.array([0.0, np.nan, 1.0, 2.0]), DT),
        lambda: LoadCell().sensor().measure(np.zeros(2), DT),
        lambda: LoadCell().sensor("skin"),
    ],
)
def test_wrong_sensors_are_refused_with_a_sentence(wrong):
    with pytest.raises(ModelError):
        wrong()
