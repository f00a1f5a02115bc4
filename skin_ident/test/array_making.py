"""Sessions on arrays of taxels in the world of hidden effects: several contacts, and declarations that a careful person would make."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from world import make_sessions, write_table
from world.effect import Effect
from world.rig import Rig

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load

CAREFUL = 0.005  # relative uncertainty of calibrations that were checked one against the other


class Scatter(Effect):
    """Calibrations that are off by a few per cent, each by its own amount, as they are in any batch."""

    def __init__(self, factors):
        self.factors = factors

    def sense(self, fine, a, rng):
        fine.taxels *= self.factors[:, None]


def record(folder: Path, cause=None, form=None, where=None, size=1.0, seed=0, taxels=3, careful=False, scatter=0.0, **how) -> list:
    """Three sessions under one contact, read back from tables; `careful` declares the width of the spread and the calibrations."""
    sessions, truth = make_sessions(cause, where, form, size, seed, n_sessions=3, n_taxels=taxels, **how)
    factors = 1.0 + scatter * np.random.default_rng([seed, 11]).standard_normal(taxels)
    said = {"spread_width_mm": 1e3 * truth.skin.width, "taxel_gain_uncertainty": CAREFUL} if careful else {}
    for i, s in enumerate(sessions):
        write_table(replace(s, taxels=s.taxels * factors, rig={**s.rig, **said}), folder / f"session_{i}.tsv")
    return load(folder)


def record_at(folder: Path, contacts_mm, cause=None, form=None, where=None, size=1.0, seed=0, taxels=3, careful=False, **how) -> list:
    """One session under each contact (x, y), in the frame in which the first contact is the origin.

    The effect is that of the first contact, as large under the others as the same amplitude makes it.
    """
    _, truth = make_sessions(cause, where, form, size, seed, n_sessions=1, n_taxels=taxels, **how)
    base, hidden = truth.rig, [(h.effect, h.amplitude) for h in truth.hidden]
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


def found(recordings: list) -> dict:
    """findings.json, the last session held out."""
    return diagnose(recordings[:-1], recordings[-1:]).findings


def names(findings: dict) -> list[tuple[str, str]]:
    """Cause and place of every finding."""
    return [(f["cause"], f["where"]) for f in findings["findings"]]


def names_or_rivals(findings: dict) -> set[tuple[str, str]]:
    """Of every finding and its alternatives."""
    return {(e["cause"], e["where"]) for f in findings["findings"] for e in (f, *f["alternatives"])}
