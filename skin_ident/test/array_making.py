"""Sessions on arrays of taxels in the world of hidden effects: several contacts, and declarations that a careful person would make."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from world import make_sessions, write_table
from world.effect import Effect
from world.rig import Rig

from skin_ident.criticism.array.analysis import ArrayCriticism, analyse
from skin_ident.criticism.array.layout import layout_of
from skin_ident.criticism.array.spreading import with_spread
from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.diagnose import diagnose
from skin_ident.criticism.noise.whitening import fit_whitener
from skin_ident.criticism.sessions.parting import without_parting
from skin_ident.criticism.sessions.session import prepare
from skin_ident.recordings.load import load
from skin_ident.recordings.mass import known_mass

CAREFUL = 0.005  # relative uncertainty of calibrations that were checked one against the other


class Spread(Effect):
    """A spread of another width, top or outline than declared: `a` is by how much, relative."""

    def __init__(self, kind):
        self.kind = kind

    def sense(self, fine, a, rng):
        x, y = fine.skin.positions.T[:, :, None]
        c, power = fine.skin.width, 2.0
        if self.kind == "wider":
            c = c * (1.0 + a)
        if self.kind == "flat":
            power += 2.0 * a
        if self.kind == "oval":
            x, y = x * np.exp(-0.5 * a), y * np.exp(0.5 * a)
        if self.kind == "deepening":
            c = c * (1.0 + a * np.maximum(fine.u, 0.0) / fine.skin.depth_max)
        fine.taxels *= np.exp(-((np.hypot(x, y) / c) ** power)) / fine.skin.shares()[:, None]


def record(folder: Path, cause=None, form=None, where=None, size=1.0, seed=0, taxels=3, careful=False, scatter=0.0, **how) -> list:
    """Three sessions under one contact, read back from tables; `careful` declares the width of the spread and the calibrations;
    `scatter` is by how much calibrations are off, each by its own amount, as they are in any batch.
    """
    sessions, truth = make_sessions(cause, where, form, size, seed, n_sessions=3, n_taxels=taxels, **how)
    factors = 1.0 + scatter * np.random.default_rng([seed, 11]).standard_normal(taxels)
    said = {"spread_width_mm": 1e3 * truth.skin.width, "taxel_gain_uncertainty": CAREFUL} if careful else {}
    for i, s in enumerate(sessions):
        write_table(replace(s, taxels=s.taxels * factors, rig={**s.rig, **said}), folder / f"session_{i}.tsv")
    return load(folder)


def record_at(
    folder: Path, contacts_mm, cause=None, form=None, where=None, size=1.0, seed=0, taxels=3, careful=False, also=(), **how
) -> list:
    """One session under each contact (x, y), in the frame in which the first contact is the origin.

    The effect is that of the first contact, as large under the others as the same amplitude makes it; `also` are [(effect, amplitude)].
    """
    _, truth = make_sessions(cause, where, form, size, seed, n_sessions=1, n_taxels=taxels, **how)
    base, hidden = truth.rig, [*((h.effect, h.amplitude) for h in truth.hidden), *also]
    said = {"spread_width_mm": 1e3 * truth.skin.width, "taxel_gain_uncertainty": CAREFUL} if careful else {}
    for i, contact in enumerate(np.array(contacts_mm, float)):
        skin = replace(base.skin, positions=base.skin.positions - 1e-3 * contact)
        rig = Rig(base.seed, base.protocol, skin, base.noise, base.rate, base.encoder_step, base.taxel_steps, base.between, base.wobble)
        measured = rig.measure(rig.clean(i, hidden)[0], i, hidden)
        declared = {**base.declared(), **said, "contact_position_mm": contact.tolist()}
        write_table(_Session(measured, declared), folder / f"at_{i}" / f"contact_{i}.tsv")
    return load(folder)


class _Session:
    """What `write_table` writes."""

    def __init__(self, m, rig):
        self.t, self.x, self.force, self.taxels, self.rig = m.t, m.x, m.force, m.taxels, rig


def analysed(recordings: list) -> ArrayCriticism:
    """The ratios alone, the last session held out, under a dispersion model that is fitted with nothing else in it."""
    layout = layout_of(recordings)
    sessions = [prepare(r) for r in with_spread(recordings, layout)]
    model = dispersion_start(sessions[:-1], known_mass(recordings[0].declared).kg)
    sessions = [without_parting(s, model.dispersion) for s in sessions]
    for steps in (6, 4):
        noise = fit_whitener([residual(model, s) for s in sessions[:-1]], sessions[:-1])
        model = fit(model, sessions[:-1], noise, steps).model
    last, thickness = len(sessions) - 1, recordings[0].declared.skin_thickness_mm
    return analyse(model, layout, sessions, [last], noise, [], thickness)


def found(recordings: list) -> dict:
    """findings.json, the last session held out."""
    return diagnose(recordings[:-1], recordings[-1:]).findings


def names(findings: dict) -> list[tuple[str, str]]:
    """Cause and place of every finding."""
    return [(f["cause"], f["where"]) for f in findings["findings"]]


def names_or_rivals(findings: dict) -> set[tuple[str, str]]:
    """Of every finding and its alternatives."""
    return {(e["cause"], e["where"]) for f in findings["findings"] for e in (f, *f["alternatives"])}
