"""The family of static shares considered here. Its plainest member is the thesis's Gaussian under the declared contact.

    share[s, i] = e^(level + scale[s]) (y[i] + leak sum over the taxels k beside i of y[k] + common mean(y)
                                        + previous y[i - 1] + next y[i + 1] + repeat[i, j] y[j]),
    y[i] = (1 + gain[i]) [(1 - tail) exp(-u^(power / 2)) + tail (1 + u)^(-fall)],        u = r^2 / width^2

(fall = 1.5: pressure in an elastic half space; K. L. Johnson, Contact Mechanics, 1985, ch. 3), with r the distance from the contact of
session s, which is displaced by `shift` along the layout's axes, and for an elliptic spread

    r^2 -> exp(-ratio) x^2 + exp(ratio) y^2 - 2 turn x y.

A member is a vector of named entries: the logarithm `level` of a factor common to all sessions, the deviation `scale` of each session from
it, then the quantities above. `previous_in_turn` and `next_in_turn` are `previous` and `next` of taxels that are counted in a ring.
`repeat_3_2`, the share of taxel 2 that taxel 3 repeats, is not in the list of names, since there is one for every pair.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from skin_ident.criticism.array.layout import Layout
from skin_models.spread.footprint import Places

HALF_SPACE = 1.5
# Shares of the taxel that is read just before, or just after, in the order of their numbers; where the reading goes round and round, the
# last is the one before the first.
IN_ORDER = ("previous", "next", "previous_in_turn", "next_in_turn")
NEAR = 1e-18  # m^2, lower bound of r^2, so that any power can be taken of it


@dataclass(frozen=True, eq=False)
class Family:
    """The members of the family for one layout. `names` are the entries of a member."""

    layout: Layout

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the entries that `shares` takes, except repeats."""
        layout = self.layout
        scales = tuple(f"scale_{s}" for s in range(len(layout.contacts)))
        shifts = tuple(f"shift_{a}" for a in range(len(layout.axes)))
        gains = tuple(f"gain_{i}" for i in range(len(layout.taxels)))
        return ("level", *scales, *shifts, "axis", *gains, "leak", "common", *IN_ORDER, "width", "power", "tail", "fall", "ratio", "turn")

    def shares(self, p: dict[str, float]) -> np.ndarray:
        """Shares (S, T) of a member, given by its non-zero entries. `width` is the logarithm of true over declared width, `power` is added
        to 2, `fall` is the logarithm of a factor on 1.5, `axis` is the angle (rad) by which the stage is turned about the origin of the
        declared frame."""
        layout = self.layout
        x, y = self._places if self._is_placed(p) else np.moveaxis(layout.places - self.off(p)[:, None], -1, 0)
        ratio = p.get("ratio", 0.0)
        square = np.exp(-ratio) * x**2 + np.exp(ratio) * y**2 - 2.0 * p.get("turn", 0.0) * x * y
        u = np.maximum(square, NEAR) / (layout.width * np.exp(p.get("width", 0.0))) ** 2
        own = np.exp(-(u ** (1.0 + 0.5 * p.get("power", 0.0))))
        if tail := p.get("tail", 0.0):
            own = (1.0 - tail) * own + tail * (1.0 + u) ** -(HALF_SPACE * np.exp(p.get("fall", 0.0)))
        for name in p:
            if name.startswith("gain_"):
                own[:, int(name[5:])] *= 1.0 + p[name]
        felt = own.copy()
        if leak := p.get("leak", 0.0):
            felt += leak * own @ self._beside
        if common := p.get("common", 0.0):
            felt += common * own.mean(axis=1, keepdims=True)
        if previous := p.get("previous", 0.0):
            felt[:, 1:] += previous * own[:, :-1]
        if following := p.get("next", 0.0):
            felt[:, :-1] += following * own[:, 1:]
        for name, step in (("previous_in_turn", 1), ("next_in_turn", -1)):
            if heard := p.get(name, 0.0):
                felt += heard * np.roll(own, step, axis=1)
        for name in filter(is_repeat, p):
            i, j = map(int, name.split("_")[1:])
            felt[:, i] += p[name] * own[:, j]
        scale = np.exp([p.get("level", 0.0) + p.get(f"scale_{s}", 0.0) for s in range(len(layout.contacts))])
        return scale[:, None] * felt

    def off(self, p: dict[str, float]) -> np.ndarray:
        """Displacement of each session's contact from its declared place under a member, (S, 2) m."""
        layout, angle = self.layout, p.get("axis", 0.0)
        shift = sum((p.get(f"shift_{a}", 0.0) * axis for a, axis in enumerate(layout.axes)), np.zeros(2))
        turned = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        return shift + layout.contacts @ turned - layout.contacts

    def _is_placed(self, p: dict[str, float]) -> bool:
        """Whether a member has every contact at its declared place."""
        return not (p.get("axis") or any(p.get(f"shift_{a}") for a in range(len(self.layout.axes))))

    @cached_property
    def _places(self) -> np.ndarray:
        """Places of the taxels as seen from the declared contacts, (2, S, T) m."""
        return np.moveaxis(self.layout.places, -1, 0)

    @cached_property
    def _beside(self) -> np.ndarray:
        """Matrix (T, T), 1 for pairs of taxels that are nearest neighbours."""
        return (Places(np.array(self.layout.taxels, float)).neighbours > 0.0).T.astype(float).toarray()


def is_repeat(name: str) -> bool:
    """Whether an entry is the share of one taxel that another one repeats."""
    return name.startswith("repeat_")
