"""Declared places of taxels and contacts, and the width of the spread: what the ratios of the taxels are compared with.

Everything comes from declarations: `taxel_positions_mm`, `contact_position_mm`, `spread_width_mm`, `taxel_gain_uncertainty` and
`skin_thickness_mm` of rig.yaml (or the layout topic of a bag), and `spread_width` in the notes of a given model.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from skin_models.model import Model

SILICONE_WIDTH = 5.25e-3  # m, c of exp(-(r/c)^2) on 4 mm of silicone: thesis section 4.3.4
# m, the part due to the discs of plunger (9.9 mm) and taxel (9.53 mm), by their variance a^2 / 4 per axis; a fit gives 5.19 mm.
DISCS = 4.86e-3
MEASURED_AT = 4.0  # mm, thickness of that silicone
APART = 1e-4  # m, distance from which two contacts count as different
FLAT, THIN = 1e-3, 0.2  # extent across a row, m rms, or as a share of that along it in small arrays, up to which all lie in one row
NOWHERE = "nothing says where the plunger presses (contact_position_mm in rig.yaml): it is taken to be at [0, 0] among the taxels"


@dataclass(frozen=True, eq=False)
class Layout:
    """T taxels under S sessions.

    taxels (T, 2)     m, in the declared frame
    contacts (S, 2)   m, where each session presses, in the same frame
    width             m, c of exp(-(r / c)^2), declared or expected
    width_declared    whether it was declared; otherwise it is a guess from the skin's thickness
    gain_std          relative standard error of every taxel's calibration; None if none is declared
    known_axes        the `axes` of all sessions where these are only some of them, so that a shift is resolved along the same ones
    """

    taxels: np.ndarray
    contacts: np.ndarray
    width: float
    width_declared: bool
    gain_std: float | None = None
    known_axes: np.ndarray | None = None

    @property
    def places(self) -> np.ndarray:
        """Positions of the taxels relative to each session's contact, (S, T, 2) m."""
        return self.taxels - self.contacts[:, None]

    @property
    def several_contacts(self) -> bool:
        """Whether the sessions press at different places."""
        return bool(np.ptp(self.contacts, axis=0).max() > APART)

    @property
    def seen(self) -> np.ndarray:
        """The positions (T, 2) that effects are given: relative to the contact if there is one, in the declared frame if there are
        several."""
        return self.taxels if self.several_contacts else self.places[0]

    @property
    def axes(self) -> np.ndarray:
        """Unit vectors (1 or 2, 2) along which taxels or contacts are spread out; none for a lone taxel under one contact."""
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
    """A warning if the ratios are judged although nobody has declared where the plunger presses."""
    return () if any(r.declared.contact_position_mm for r in recordings) else (NOWHERE,)


def layout_of(recordings: list, model: Model | None = None) -> Layout | str:
    """The layout, or one sentence on why the ratios of the taxels cannot be judged."""
    count = len(recordings[0].taxels)
    if count < 2:
        return (
            "there is one taxel: the place of the contact and an error of calibration show only in comparison with other taxels"
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
    """The width, m, and whether it is known. The skin's contribution, beside that of the discs, grows with its thickness."""
    noted = (model.notes.get("spread_width") or {}) if model is not None else {}
    if isinstance(noted, dict) and "value" in noted:
        return float(noted["value"]), True
    if declared.spread_width_mm:
        return 1e-3 * declared.spread_width_mm, True
    skin = np.sqrt(SILICONE_WIDTH**2 - DISCS**2) * (declared.skin_thickness_mm or MEASURED_AT) / MEASURED_AT
    return float(np.hypot(DISCS, skin)), False
