"""The mass between load cell and skin, where it is not estimated: the same value for every tool, and its source."""

from dataclasses import dataclass

from skin_ident.recordings.declared import FILE_NAME, Declared

MASS_PER_THICKNESS = 0.108  # kg/m: silicone above one taxel's sensing area, thesis section 4.3.1
USUAL_MM = 4.0  # thickness of the skin in most of the thesis


@dataclass(frozen=True)
class KnownMass:
    """A mass that is held, kg; `source` is a phrase that follows "held at"."""

    kg: float
    source: str


def known_mass(declared: Declared, thickness_mm: float | None = None) -> KnownMass:
    """The declared mass, or that of silicone with the thickness requested, else declared, else usual."""
    if declared.moving_mass_kg is not None:
        return KnownMass(declared.moving_mass_kg, f"what {FILE_NAME} declares (moving_mass_kg)")
    thick, why = USUAL_MM, f"because neither moving_mass_kg nor skin_thickness_mm is declared in {FILE_NAME}"
    if declared.skin_thickness_mm is not None:
        thick, why = declared.skin_thickness_mm, f"as {FILE_NAME} declares"
    if thickness_mm is not None:
        thick, why = thickness_mm, "as requested"
    return KnownMass(MASS_PER_THICKNESS * 1e-3 * thick, f"that of silicone {thick:g} mm thick (thesis 4.3.1), {why}")
