"""Spikes of one channel are bridged, fast touches are not: batteries with both, from the plain equations."""

import json
from dataclasses import replace

import numpy as np
import pytest
from making import SILICONE, recording, response, write_table

from skin_ident.cli.fit import main
from skin_ident.estimators.fit import Options, fit_recordings
from skin_ident.quality import inspected
from skin_ident.recordings.recording import Recording
from skin_ident.spikes import jumps, spikes_of
from skin_ident.stretches import runs

DT, END, FINE = 0.01, 60.0, 10  # s, s, and how many samples of the equations make one of the record
ABOVE = -0.3  # mm, where the plunger waits
B1, K1 = SILICONE[4][1:3]
SEEDS = range(6)


def battery(seed, sigma=0.03, encoder=1e-6, speeds=(5.0, 20.0)):
    """Slow ramps and holds at up to 3 mm/s, and now and then a fast touch: down and up again at 5 to 20 mm/s, 0.1 to 0.4 mm deep.

    The equations run ten times as fine as the record: contact begins and ends between its samples.
    """
    rng = np.random.default_rng(seed)
    at, depth = [0.0, 1.0], [ABOVE, ABOVE]

    def to(x, speed, hold):
        at.append(at[-1] + abs(x - depth[-1]) / speed)
        depth.append(x)
        at.append(at[-1] + hold)
        depth.append(x)

    while at[-1] < END - 6.0:
        if rng.random() < 0.4:
            speed = rng.uniform(*speeds)
            to(rng.uniform(0.1, 0.4), speed, 0.0)
            to(ABOVE, speed, rng.uniform(0.2, 1.0))
        else:
            for _ in range(4):
                deeper = depth[-1] < 0.6
                to(rng.uniform(0.7, 1.2) if deeper else rng.uniform(0.1, 0.5), rng.uniform(0.5, 3.0), rng.uniform(0.1, 0.5))
            to(ABOVE, 2.0, 0.3)
    t = np.arange(0.0, END, DT / FINE)
    x = 1e-3 * np.interp(t, at, depth)
    force, taxels = response(np.array([x, np.gradient(x, t), 0.0 * x]), shares=(1.0, 0.4), dt=DT / FINE)
    x, *read = (y[::FINE] for y in (x, force, *taxels))
    read = [y + sigma * rng.standard_normal(y.size) for y in read]
    return Recording("battery", t[::FINE], x + encoder * rng.standard_normal(x.size), read[0], np.array(read[1:]))


CUTS = {
    "all": lambda r: r,
    "force and depth": lambda r: replace(r, taxels=np.empty((0, 0)), taxel_names=(), taxel_units=()),
    "taxels and depth": lambda r: replace(r, force=None),
    "one taxel and depth": lambda r: replace(r.with_taxels((0,)), force=None),
    "no depth": lambda r: replace(r, depth=None),
    "taxels": lambda r: replace(r, depth=None, force=None),
}


def rows_of(r):
    return ({} if r.depth is None else {"depth": r.depth}) | r.channels


def bridged(r):
    """How many spikes are bridged in a recording."""
    return sum(len(at) for at in inspected(r)[2].spikes.values())


def struck(r, names, seed, where=None, size=(0.5, 3.0), count=8):
    """The recording with spikes of 1 to 3 samples in each of the channels, `size` times their range, and where they begin."""
    rng = np.random.default_rng([seed, 7])
    places = np.arange(20, len(r) - 20, 12) if where is None else where
    at, width = rng.choice(places, count, replace=False), rng.integers(1, 4, count)
    rows = {}
    for name in names:
        y = rows_of(r)[name].copy()
        for i, n in zip(at, width, strict=True):
            y[i : i + n] += rng.choice([-1, 1]) * rng.uniform(*size) * np.ptp(rows_of(r)[name])
        rows[name] = y
    return r.with_channels(rows), at


def resting(r):
    """Places about which the plunger has stood still in contact for a while."""
    still = np.convolve(np.abs(np.diff(r.depth, append=r.depth[-1])) > 1e-5, np.ones(25), "same") < 0.5
    return np.array([i for i in range(30, len(r) - 30, 12) if still[i] and r.depth[i] > 5e-5])


@pytest.mark.parametrize("cut", CUTS)
def test_fast_touches_are_no_spikes(cut):
    made = [CUTS[cut](battery(seed)) for seed in SEEDS]
    would = sum(runs(jumps(y))[0].size for r in made for y in rows_of(r).values())
    assert would > 40 and sum(map(bridged, made)) <= 0.01 * would


@pytest.mark.parametrize("seed", SEEDS)
def test_fast_touches_are_fitted(seed):
    """Bridged, they took 10 to 22 % of b1 away; speeds by differences of samples, between which contact begins, leave 1 to 5 %."""
    estimate = fit_recordings([battery(seed)])
    assert estimate.values["b1"] == pytest.approx(B1, rel=0.07) and estimate.values["k1"] == pytest.approx(K1, rel=0.01)
    assert not any("spike" in w for w in estimate.warnings)


@pytest.mark.parametrize("late", [0, 2])
@pytest.mark.parametrize("off", [-0.2e-3, 0.2e-3])
def test_a_late_encoder_or_a_wrong_zero_makes_no_spikes_of_touches(off, late):
    for cut in ("all", "force and depth"):
        made = [CUTS[cut](battery(seed)) for seed in SEEDS]
        assert sum(bridged(replace(r, depth=np.roll(r.depth, late) + off)) for r in made) <= 2


@pytest.mark.parametrize("cut", CUTS)
def test_spikes_of_one_channel_are_found_whatever_the_plunger_does(cut):
    for name in rows_of(CUTS[cut](battery(0))):
        hit = []
        for seed in SEEDS:
            r, at = struck(CUTS[cut](battery(seed)), [name], seed)
            found = spikes_of(r)
            hit += [found[name][i : i + 3].any() for i in at]
            assert not any(mask.any() for other, mask in found.items() if other != name)
        assert np.mean(hit) > 0.95, name


def test_spikes_do_no_harm_once_they_are_bridged():
    for seed in SEEDS:
        clean = battery(seed)
        r, _ = struck(clean, ["force"], seed)
        whole, mended = fit_recordings([clean]).values, fit_recordings([r]).values
        assert all(mended[n] == pytest.approx(whole[n], rel=0.03) for n in ("b1", "k1", "b2", "k2"))


@pytest.mark.parametrize("cut", ["all", "force and depth", "taxels and depth"])
def test_a_discharge_into_every_channel_while_the_plunger_rests_is_none_of_the_skin(cut):
    hit = []
    for seed in SEEDS:
        whole = CUTS[cut](battery(seed))
        r, at = struck(whole, list(whole.channels), seed, resting(whole))
        hit += [mask[i : i + 3].any() for name, mask in spikes_of(r).items() if name != "depth" for i in at]
    assert np.mean(hit) > 0.95


@pytest.mark.parametrize("samples", [1, 2, 3, 4])
def test_what_all_channels_feel_in_proportion_under_a_moving_plunger_is_the_skin(samples):
    """Taps of so many samples, of any force and in any motion: the depth goes along by what k1 + k2 of it would.

    Of 48 in four rows each, one may lie at a corner of the motion, where one row is seen to jump and the others are not.
    """
    seen = []
    for seed in SEEDS:
        r, rng = battery(seed), np.random.default_rng(seed)
        force, taxels, depth = r.force.copy(), r.taxels.copy(), r.depth.copy()
        for at in rng.choice(np.arange(30, len(r) - 30, 20), 8, replace=False):
            tap = rng.uniform(3.0, 30.0)
            force[at : at + samples] += tap
            taxels[:, at : at + samples] += tap * np.array([[0.6], [0.24]])
            depth[at : at + samples] += tap / 12385.0
        seen += [bridged(replace(r, force=force, taxels=taxels, depth=x)) for x in (depth, None)]
    assert sum(seen) <= 1


def test_a_lone_channel_has_nothing_to_be_held_against():
    r, at = struck(replace(battery(0), depth=None, taxels=np.empty((0, 0)), taxel_names=(), taxel_units=()), ["force"], 0)
    assert all(spikes_of(r)["force"][i : i + 3].any() for i in at)


def test_the_terminal_says_when_and_keeps_them_where_it_is_asked(tmp_path, capsys):
    r = battery(0)
    force = r.force.copy()
    for at in (1000, 2000, 3000):
        force[at] += 60.0
    path, out = write_table(tmp_path / "a.csv", replace(r, force=force)), tmp_path / "out"
    assert main([str(path), "--out", str(out)]) == 0
    assert "force: 3 spikes interpolated (at 10.00, 20.00 and 30.00 s)" in " ".join(capsys.readouterr().out.split())
    (told,) = json.loads((out / "fit.json").read_text())["notes"]["telemetry"].values()
    assert told["spikes"] == {"force": 3} and told["spikes_at_s"]["force"] == pytest.approx([10.0, 20.0, 30.0])
    assert main([str(path), "--keep-spikes"]) == 0 and "bridged" not in capsys.readouterr().out
    kept = fit_recordings([replace(r, force=force)], Options(keep_spikes=True))
    assert kept.residuals["force"].rmse > 1.5 * fit_recordings([replace(r, force=force)]).residuals["force"].rmse


def test_of_many_spikes_the_first_are_named():
    r = battery(0)
    force = r.force.copy()
    force[1000:5000:800] += 60.0
    assert "force: 5 spikes interpolated (at 10.00, 18.00, 26.00, … s)" in inspected(replace(r, force=force))[2].warnings
    force[1800:] = r.force[1800:]
    assert "force: 1 spike interpolated (at 10.00 s)" in inspected(replace(r, force=force))[2].warnings


@pytest.mark.parametrize("seed", range(4))
def test_what_hits_the_cable_of_the_encoder_and_of_the_load_cell_at_once_is_no_touch(seed):
    """2 mm within a sample of 10 ms are 200 mm/s, of a stage that has not gone a tenth of that, and 6 N are not what 2 mm press."""
    r = battery(seed, speeds=(2.0, 3.0))
    rng = np.random.default_rng(seed)
    at = rng.choice(np.arange(50, len(r) - 50), 10, replace=False)
    depth, force = r.depth.copy(), r.force.copy()
    depth[at] += 2e-3 * rng.choice([-1.0, 1.0], at.size)
    force[at] += 6.0 * rng.choice([-1.0, 1.0], at.size)
    found = spikes_of(replace(r, depth=depth, force=force))
    assert found["depth"][at].sum() == 10 and found["force"][at].sum() >= 6  # the others stand where the stage could do as much


def test_a_force_that_froze_is_told_by_the_taxels_that_feel_it_and_not_by_those_that_jump():
    """Four open taxels jump further than any load moves the others, for too long to be bridged as spikes."""
    r, rng = recording(n=3000, shares=(0.5, 0.3, 0.0, 0.0, 0.0, 0.0), sigma=0.01), np.random.default_rng(4)
    force, taxels = r.force.copy(), r.taxels.copy()
    force[1000:1120] = force[1000]
    for y, start in zip(taxels[2:], rng.integers(100, 2900, 4), strict=True):
        y[start : start + 8] += 20.0
    quality = inspected(replace(r, depth=None, force=force, taxels=taxels))[2]
    assert quality.frozen["force"] == 120 and not any(quality.spikes.values())
