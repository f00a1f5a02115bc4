"""Where taxels and contacts are said to be, and how wide the spread is said to be: what the ratios of the taxels are judged against.

Everything comes from declarations: `taxel_positions_mm`, `contact_position_mm`, `spread_width_mm`, `taxel_gain_uncertainty` and
`skin_thickness_mm` of rig.yaml (or the layout topic of a bag), and `spread_width` in the notes of a given model.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_models.model import Model

SILICONE_WIDTH = 5.25e-3  # m, c of exp(-(r/c)^2) on 4 mm of silicone: thesis section 4.3.4
DISCS = 4.86e-3  # m, what of it plunger (9.9 mm) and taxel (9.53 mm) make, by the variance of discs, a^2 / 4 per axis; a fit says 5.19
MEASURED_AT = 4.0  # mm
APART = 1e-4  # m, by which contacts must differ to count as different
FLAT, THIN = 1e-3, 0.2  # m rms, or of the width of small arrays, up to which taxels and contacts lie in one row
NOWHERE = "nobody says where the plunger presses (contact_position_mm in rig.yaml): it is taken to be at [0, 0] among the taxels"


@dataclass(frozen=True, eq=False)
class Layout:
    """T taxels under S sessions.

    taxels (T, 2)     m, in the frame of the declaration
    contacts (S, 2)   m, where each session presses, in the same frame
    width             m, c of exp(-(r / c)^2) as declared or to be expected
    width_declared    whether somebody said so; otherwise it follows from the skin's thickness and may well be otherwise
    gain_std          relative standard error of every taxel's calibration; None where nobody declared one
    known_axes        the `axes` of the sessions of which these are some: a shift is told along the same ones in all of them
    """

    taxels: np.ndarray
    contacts: np.ndarray
    width: float
    width_declared: bool
    gain_std: float | None = None
    known_axes: np.ndarray | None = None

    @property
    def places(self) -> np.ndarray:
        """Where the taxels are as seen from each session's contact, (S, T, 2) m."""
        return self.taxels - self.contacts[:, None]

    @property
    def several_contacts(self) -> bool:
        """Whether the sessions press at different places."""
        return bool(np.ptp(self.contacts, axis=0).max() > APART)

    @property
    def seen(self) -> np.ndarray:
        """The taxels (T, 2) as effects are told of them: from the one contact, or in the declared frame where there are several."""
        return self.taxels if self.several_contacts else self.places[0]

    @property
    def axes(self) -> np.ndarray:
        """Unit vectors (1 or 2, 2) along which the taxels, or the contacts, are spread out; none for a lone taxel under one contact."""
        if self.known_axes is not None:
            return self.known_axes
        points = self.places.reshape(-1, 2) - self.places.reshape(-1, 2).mean(axis=0)
        _, size, axes = np.linalg.svd(points, full_matrices=False)
        kept = axes[size / np.sqrt(len(points)) > min(FLAT, THIN * size.max() / np.sqrt(len(points)))]
        return kept * np.where(kept[np.arange(len(kept)), np.abs(kept).argmax(axis=1)] < 0.0, -1.0, 1.0)[:, None]

    def of(self, sessions: list[int]) -> "Layout":
        """The same for some of the sessions."""
        return replace(self, contacts=self.contacts[sessions], known_axes=self.axes)


def unplaced(recordings: list) -> tuple[str, ...]:
    """The warning of ratios that are judged although nobody says where the plunger presses."""
    return () if any(r.declared.contact_position_mm for r in recordings) else (NOWHERE,)


def layout_of(recordings: list, model: Model | None = None) -> Layout | str:
    """The layout, or one sentence saying why the ratios of the taxels cannot be judged."""
    count = len(recordings[0].taxels)
    if count < 2:
        return (
            "there is one taxel: where it is pressed, and how well it is calibrated, shows only beside others"
            if count
            else "there is no taxel"
        )
    if any("V" in r.taxel_units for r in recordings):
        return "the taxels are not calibrated, so their ratios say nothing"
    if any(len(r.declared.taxel_positions_mm) != count for r in recordings):
        return "rig.yaml does not declare where every taxel is (taxel_positions_mm)"
    taxels = 1e-3 * np.array(recordings[0].declared.taxel_positions_mm, float)
    if np.ptp(taxels, axis=0).max() < APART:
        return "all taxels are declared to be at one place"
    contacts = 1e-3 * np.array([r.declared.contact_of(r.name) for r in recordings], float)
    width, said = _width(recordings[0].declared, model)
    return Layout(taxels, contacts, width, said, recordings[0].declared.taxel_gain_uncertainty)


def _width(declared: Any, model: Model | None) -> tuple[float, bool]:
    """The width, m, and whether it is known. What the skin adds to the discs' own width grows with its thickness."""
    noted = (model.notes.get("spread_width") or {}) if model is not None else {}
    if isinstance(noted, dict) and "value" in noted:
        return float(noted["value"]), True
    if declared.spread_width_mm:
        return 1e-3 * declared.spread_width_mm, True
    skin = np.sqrt(SILICONE_WIDTH**2 - DISCS**2) * (declared.skin_thickness_mm or MEASURED_AT) / MEASURED_AT
    return float(np.hypot(DISCS, skin)), False
