"""Writes the extended model of a scan as a model that the simulated skin loads."""

from dataclasses import replace
from typing import Any

import numpy as np

from skin_ident.criticism.scan.cells import Cells
from skin_ident.criticism.scan.family import level, spread
from skin_ident.criticism.scan.fitting import Member
from skin_models.dispersion import Dispersion
from skin_models.effect import Effect
from skin_models.effects.dead_zone import HardDeadZone
from skin_models.effects.force_offset import ForceOffset
from skin_models.effects.nonlinear_stiffness import PolynomialStiffness
from skin_models.effects.position_offset import PositionOffset
from skin_models.effects.saturation import Saturation
from skin_models.model import Model
from skin_models.parameter import clipped

POINTS = 61  # of the table of a spread's shape, between 0 and 3 widths
WIDEST = 6.0  # widths: the last point of that table
STATIC = (
    "static spread scan: only k1, the force that reaches the taxel per depth, and the spread were measured; no damping, nothing dispersed"
)


def model_of(m: Member, given: Model | None, name: str) -> Model:
    """A member written as a model. Without a given model it is static: parameters that were not measured are zero, and `source` says so.

    The simulated skin has a level k1 x plus a square and a cube of x, and a width that grows linearly; both are fitted over the depths of
    the scan. A drift with the order of the rows and an off-centre plunger cannot be written in it.
    """
    base = given or Model(Dispersion(m=0.0, b1=0.0, k1=1.0, b2=0.0, k2=0.0), name=name, source=STATIC)
    width, growth = surface_width(m)
    k1, square, cube = _polynomial(m, growth)
    dispersion = replace(base.dispersion, k1=k1) if m.k_free or given is None else base.dispersion
    effects = [*base.effects, *_effects(m, square, cube)]
    if not m.k_free and (square or cube) and given is not None:
        effects = [*base.effects, *_effects(m, *_beside(m, growth))]
    notes = {k: v for k, v in base.notes.items() if k != "spread"} | {"spread_width": {"value": width, "unit": "m"}}
    measured = _notes(m, growth)
    return replace(base, dispersion=dispersion, effects=tuple(effects), notes=notes | ({"spread": measured} if measured else {}))


def baseline_of(m: Member, given: Model | None, name: str) -> Model:
    """The baseline as a model: the given one, or the static one."""
    return given or model_of(m, None, name)


def surface_width(m: Member) -> tuple[float, float]:
    """Width at the surface (m) and its relative growth per depth (1/m), from a least-squares line through the width over depth."""
    z = np.linspace(0.1, 1.0, 40) * m.scale.deepest
    c = m.values["width"] * (1.0 + m.values["growth"] * (z - m.scale.mean)) * (z / m.scale.mean) ** m.values["depth_power"]
    slope, at_zero = np.polyfit(z, c, 1)
    bends = m.values["growth"] or m.values["depth_power"]
    return (float(at_zero), float(slope / at_zero)) if bends else (m.values["width"], 0.0)


def _polynomial(m: Member, growth: float) -> tuple[float, float, float]:
    """k1 (N/m) and the factors of depth^2 and depth^3 (N/m^2, N/m^3), for the force at the centre as a function of the tip's depth.

    The simulated skin conserves the total force, so that a growing width lowers the force at the centre. The level is raised to make up
    for that.
    """
    x = np.linspace(0.05, 1.0, 60) * m.scale.deepest
    values = m.values | {"shift": 0.0}
    f = float(np.mean(m.k)) * level(values, x, m.scale) * (1.0 + growth * x) ** 2
    plain = m.values["exponent"] == 1.0 and not (m.values["square"] or m.values["cube"] or growth) and m.scale.law is None
    powers = x[:, None] ** np.arange(1, 2 if plain else 4)
    found = np.linalg.lstsq(powers / m.scale.deepest ** np.arange(1, powers.shape[1] + 1), f, rcond=None)[0]
    found = found / m.scale.deepest ** np.arange(1, found.size + 1)
    return (float(max(found[0], 0.0)), *(float(v) for v in np.r_[found[1:], np.zeros(3 - found.size)]))


def _beside(m: Member, growth: float) -> tuple[float, float]:
    """Factors of depth^2 and depth^3 (N/m^2, N/m^3) that must be added to the level of a given model, which is kept as it is."""
    x = np.linspace(0.05, 1.0, 60) * m.scale.deepest
    own = level(m.values | {"shift": 0.0, "square": 0.0, "cube": 0.0, "exponent": 1.0}, x, m.scale)
    more = float(np.mean(m.k)) * level(m.values | {"shift": 0.0}, x, m.scale) * (1.0 + growth * x) ** 2 - own
    square, cube = np.linalg.lstsq(np.stack([x**2, x**3], axis=1) / m.scale.deepest**2, more, rcond=None)[0] / m.scale.deepest**2
    return float(square), float(cube)


def _effects(m: Member, square: float, cube: float) -> list[Effect]:
    v, found = m.values, []
    if v["shift"]:
        found.append(_made(PositionOffset, "rig", offset=-v["shift"]))
    if square or cube:
        found.append(_made(PolynomialStiffness, "skin", square_sensed=square, cube_sensed=cube))
    if v["threshold"]:
        found.append(_made(HardDeadZone, "taxel", threshold=v["threshold"]))
    if v["offset"]:
        found.append(_made(ForceOffset, "taxel", offset=v["offset"]))
    if np.isfinite(v["ceiling"]):
        found.append(_made(Saturation, "taxel", level=v["ceiling"]))
    return found


def _made(cls: type[Effect], where: str, **values: float) -> Effect:
    """The effect with the fitted values, clipped to its bounds."""
    return cls(where, **clipped(cls, **values))


def _notes(m: Member, growth: float) -> dict[str, Any]:
    """`notes.spread` of the model."""
    v, notes = m.values, {}
    if v["power"] != 2.0 or any(v[name] for name in ("tail", "disc", "bend2", "bend3", "bend4")):
        u = np.r_[np.linspace(0.0, 3.0, POINTS), np.linspace(3.25, WIDEST, 12)]
        shape = np.maximum(spread_at(m, u * v["width"]), 0.0)
        notes["table"] = {"at": [round(float(a), 4) for a in u], "shares": [float(f"{s:.5g}") for s in shape / shape[0]]}
    if growth:
        notes["growth"] = {"value": growth, "unit": "1/m"}
    if v["ratio"]:
        notes["ratio"] = {"value": float(np.exp(v["ratio"])), "unit": "1"}
    return notes


def spread_at(m: Member, r: np.ndarray) -> np.ndarray:
    """The spread (n,) at distances r (m) from the centre, at the mean depth, for an unknown direction of the scan."""
    zero, one = np.zeros(r.size), np.ones(r.size)
    number = np.zeros(r.size, int)
    cells = Cells(zero, one * m.scale.mean, r, zero, zero, number, number, number)
    return spread(m.values | {"centre": 0.0}, cells, m.scale)
