"""Skins that were measured: models shipped as YAML, populations drawn from their unit-to-unit spread, and other thicknesses.

    material("silicone_4mm").model             the mean specimen
    population("silicone_4mm", 100, seed=1)    a hundred specimens
    silicone(5e-3)                             a thickness between the measured ones, with its uncertainty
    free_mass("silicone_4mm")                  as fitted with the mass left free
    frubber_transmission(1e-3, dt)             Frubber from applied to sensed force, as a filter

A file in `data/materials` is a model file (`skin_models.model_file`) whose parameters carry the printed `std`, and whose notes give
thickness, spread width and unit-to-unit variation where they were measured.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from importlib.resources import as_file, files
from typing import Any

import numpy as np
import yaml
from scipy.interpolate import PchipInterpolator

from skin_models.dispersion import Dispersion
from skin_models.errors import ModelError
from skin_models.model import Model
from skin_models.model_file import load_model
from skin_models.thesis.tables import estimates, transfer_functions
from skin_models.transmission import Transmission

SILICONE = ("silicone_2mm", "silicone_4mm", "silicone_6mm")
SCALED = ("b1", "k1", "b2", "k2")


@dataclass(frozen=True)
class Material:
    """A measured or interpolated skin. `std` and `unit_to_unit` are by parameter, SI; NaN or absent where nobody measured it."""

    name: str
    model: Model
    thickness: float  # m
    std: Mapping[str, float]  # as printed, or of the interpolation
    unit_to_unit: Mapping[str, float]  # standard deviation between specimens, with n - 1
    spread_width: float = math.nan  # m, c of the Gaussian as a 9.53 mm taxel under a 9.9 mm plunger sees it


def names() -> tuple[str, ...]:
    """The materials that are shipped."""
    return tuple(sorted(f.name.removesuffix(".yaml") for f in _folder().iterdir() if f.name.endswith(".yaml")))


def material(name: str) -> Material:
    """A shipped material. Raises `ModelError` listing what exists."""
    if name not in names():
        raise ModelError(f"no material is called {name!r}; known are {', '.join(names())}")
    file = _folder() / f"{name}.yaml"
    with as_file(file) as path:
        model = load_model(path)
    written = yaml.safe_load(file.read_text(encoding="utf-8"))["dispersion"]
    notes = model.notes
    return Material(
        name=name,
        model=model,
        thickness=notes["thickness"]["value"],
        std={p: float(entry["std"]) for p, entry in written.items() if "std" in entry},
        unit_to_unit=_values(notes.get("unit_to_unit", {})),
        spread_width=notes.get("spread_width", {}).get("value", math.nan),
    )


def free_mass(name: str) -> Material:
    """A silicone as the thesis first fitted it, with the mass left free (Table 4-4); `material` has the mass of the block of skin.

    Its 0.2 to 0.27 kg are no mass of skin: their weight, which is constant, stands for a force that is not proportional to depth, and k2
    makes up for it. b1 and k1 are the same. Raises `ModelError` for anything but the three silicones.
    """
    if name not in SILICONE:
        raise ModelError(f"the mass was left free for {', '.join(SILICONE)}, not for {name!r}")
    fixed, found = material(name), estimates("4-4", name.removeprefix("silicone_"))
    dispersion = Dispersion(**{p: e.value for p, e in found.items()})
    model = replace(fixed.model, dispersion=dispersion, name=f"{fixed.model.name}, mass free", source="thesis Table 4-4")
    return replace(fixed, name=f"{name}, mass free", model=model, std={p: e.std for p, e in found.items()}, unit_to_unit={})


def _folder() -> Any:
    return files("skin_models") / "data" / "materials"


def _values(entries: Mapping[str, Any]) -> dict[str, float]:
    return {name: float(entry["value"]) for name, entry in entries.items()}


def population(skin: str | Material, n: int, seed: int) -> tuple[Model, ...]:
    """`n` specimens whose parameters vary as the measured ones did.

    Each parameter is lognormal (a stiffness is positive) with the material's mean and unit-to-unit standard deviation, independent of
    the others: three specimens tell nothing of a correlation, and fix the deviation itself only to a factor of 0.5 to 6 (95 %).
    Raises `ModelError` for a material of which one specimen was measured, and for a number below one.
    """
    if n < 1:
        raise ModelError(f"a population needs one specimen or more, not {n}")
    skin = material(skin) if isinstance(skin, str) else skin
    if not skin.unit_to_unit:
        raise ModelError(f"{skin.name} was measured on one specimen: how units differ is not known, so no population can be drawn")
    rng = np.random.default_rng(seed)
    mean = np.array([getattr(skin.model.dispersion, p) for p in skin.unit_to_unit])
    relative = np.array(list(skin.unit_to_unit.values())) / mean
    sigma = np.sqrt(np.log1p(relative**2))
    draws = np.exp(rng.normal(np.log(mean) - sigma**2 / 2, sigma, (n, mean.size)))
    return tuple(_specimen(skin, dict(zip(skin.unit_to_unit, map(float, row), strict=True)), i) for i, row in enumerate(draws))


def _specimen(skin: Material, values: dict[str, float], i: int) -> Model:
    return replace(skin.model, dispersion=replace(skin.model.dispersion, **values), name=f"{skin.model.name}, specimen {i}")


def silicone(thickness: float, extrapolate: bool = False) -> Material:
    """Silicone of any thickness (m), from the measured 2, 4 and 6 mm.

    Every parameter runs through the three measured values, its logarithm as a monotone cubic (PCHIP) of the thickness; the mass is that
    of a block and so proportional. The standard deviation combines that of the measured thicknesses with half the difference between
    this curve and straight lines between the points: three points do not tell the form of the curve.
    Raises `ModelError` outside 2 to 6 mm unless `extrapolate`; then the outer tangent is followed, at most a factor of two outside, and
    the deviation grows with the distance as the form of the curve does.
    """
    measured = [material(name) for name in SILICONE]
    h = np.array([m.thickness for m in measured])
    if not h[0] <= thickness <= h[-1]:
        _check_extrapolation(thickness, h, extrapolate)
    std, spread, value = {}, {}, {"m": float(measured[0].model.dispersion.m / h[0] * thickness)}
    for p in SCALED:
        at = np.array([getattr(m.model.dispersion, p) for m in measured])
        value[p], form = _curve(h, at, thickness)
        inside = np.clip(thickness, h[0], h[-1])
        std[p] = float(np.hypot(value[p] * np.interp(inside, h, [m.std[p] for m in measured] / at), form))
        spread[p] = float(value[p] * np.interp(inside, h, [m.unit_to_unit[p] for m in measured] / at))
    where = "interpolated between" if h[0] <= thickness <= h[-1] else "extrapolated from"
    name = f"silicone {thickness * 1e3:g} mm"
    model = Model(Dispersion(**value), name=name, source=f"{where} 2, 4 and 6 mm of thesis Table 4-5")
    return Material(name, model, float(thickness), std, spread)


def _check_extrapolation(thickness: float, h: np.ndarray, allowed: bool) -> None:
    if not (math.isfinite(thickness) and h[0] / 2 <= thickness <= 2 * h[-1]):
        raise ModelError(f"a thickness of {thickness * 1e3:g} mm is too far from the measured 2 to 6 mm for any statement")
    if not allowed:
        raise ModelError(
            f"silicone was measured from 2 to 6 mm, not at {thickness * 1e3:g} mm: pass extrapolate=True to follow the curve beyond"
        )


def _curve(h: np.ndarray, at: np.ndarray, x: float) -> tuple[float, float]:
    """The value at `x` and the uncertainty of the curve's form, from the points (h, at)."""
    curve = PchipInterpolator(h, np.log(at))
    inside = float(np.clip(x, h[0], h[-1]))
    value = float(np.exp(curve(inside) + curve.derivative()(inside) * (x - inside)))
    i = 1 if inside > h[1] else 0
    line = at[i] + (at[i + 1] - at[i]) / (h[i + 1] - h[i]) * (x - h[i])
    return value, abs(value - max(line, 0.0)) / 2.0


def frubber_transmission(speed: float, dt: float) -> Transmission:
    """4 mm of Frubber from applied to sensed force at sample period `dt` (s): the filter of eq 32 with Table 4-7.

    It was identified at a deformation speed of 0.25 mm/s (one experiment) and of 1 mm/s (the mean of two is taken). Its parameters differ
    by factors of 4 to 24 between the two, so Frubber is not linear force to force either, and other speeds raise `ModelError`.

    This is no `Material`, and cannot be one: Table 4-7 prints every parameter over a mass that it does not print. Force to force the
    mass drops out (here it is 1 kg); from depth to force it is the scale. Were it taken from the stiffness of Table 4-6, it would be
    41 kg: no mass of skin, but what a filter of second order makes of a nonlinear skin's lag.
    """
    found = [t for t in transfer_functions() if math.isclose(t.speed, speed, rel_tol=0.01)]
    if not found:
        raise ModelError(f"Frubber was identified force to force at 0.25 and at 1 mm/s, not at {speed * 1e3:g} mm/s")
    mean = {p: float(np.mean([getattr(t, p) for t in found])) for p in SCALED}
    return Transmission(Dispersion(m=1.0, **mean), dt)
