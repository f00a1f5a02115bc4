"""What presses on the skin at one instant."""

from dataclasses import dataclass

import numpy as np

from skin_models.arrays import numbers
from skin_models.errors import SkinError


class ContactError(SkinError):
    """A contact whose numbers cannot be used."""


@dataclass(frozen=True, eq=False)
class Contacts:
    """C contacts.

    position (C, 3)  m, centres of the patches
    force    (C,)    N, pressing into the skin, not negative
    radius   (C,)    m, of a disc with even pressure; 0 is a point
    depth    (C,)    m, for kernels whose width depends on it; NaN if unknown
    normal   (C, 3)  out of the skin, of any length; None takes that of the nearest taxel

    Raises `ContactError` for shapes that do not match, numbers that are not finite, and forces and radii that are negative.
    """

    position: np.ndarray
    force: np.ndarray
    radius: np.ndarray | float = 0.0
    depth: np.ndarray | float = np.nan
    normal: np.ndarray | None = None

    def __post_init__(self) -> None:
        position = numbers(self.position, "positions of contacts", ContactError)
        if position.size % 3 or (position.ndim > 1 and position.shape[-1] not in (0, 3)):
            raise ContactError(f"every contact needs a position (x, y, z), not an array of shape {position.shape}")
        position = np.array(position.reshape(-1, 3))
        count = len(position)
        object.__setattr__(self, "position", position)
        for name in ("force", "radius", "depth"):
            try:
                value = np.array(np.broadcast_to(numbers(getattr(self, name), f"{name} of contacts", ContactError), (count,)))
            except ValueError as error:
                raise ContactError(f"{count} contacts need as many values of {name}") from error
            object.__setattr__(self, name, value)
        if self.normal is not None:
            object.__setattr__(self, "normal", _unit(numbers(self.normal, "normals of contacts", ContactError), count))
        _check(self)

    def __len__(self) -> int:
        return len(self.position)


def _check(c: Contacts) -> None:
    if not np.all(np.isfinite(c.position)):
        raise ContactError("every contact needs a finite position")
    if not np.all((c.force >= 0.0) & np.isfinite(c.force)):
        raise ContactError("every contact needs a finite force that presses into the skin (not negative)")
    if not np.all((c.radius >= 0.0) & np.isfinite(c.radius)):
        raise ContactError("every contact needs a finite radius, 0 for a point")
    if np.isinf(c.depth).any():
        raise ContactError("every contact needs a finite depth, or NaN where it is unknown")


def _unit(normal: np.ndarray, count: int) -> np.ndarray:
    if normal.size != 3 * count:
        raise ContactError(f"{count} contacts need as many normals (x, y, z), not an array of shape {normal.shape}")
    normal = normal.reshape(count, 3)
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    if not np.all((length > 0.0) & np.isfinite(length)):
        raise ContactError("every normal of a contact must be a direction, not zero or NaN")
    return normal / length


def sphere_patch(radius: float, depth: float) -> float:
    """Radius (m) of the even disc that stands for a sphere pressed `depth` deep, from Hertz: the patch is sqrt(radius * depth) wide
    and its pressure sqrt(1 - (r / a)^2) has the second moment of an even disc of sqrt(4 / 5) a. Source: Johnson, Contact Mechanics, ch. 4.
    """
    return float(np.sqrt(0.8 * max(radius * depth, 0.0)))


def disc_points() -> tuple[np.ndarray, np.ndarray]:
    """Offsets (19, 2) in units of the disc's radius, and weights (19,) summing to 1, that stand for an even disc.

    Rings of 6 and 12 about the centre, radial Gauss-Radau: exact for polynomials up to degree 4 in the offsets.
    """
    # Radau on u = r^2 in [0, 1] with the node u = 0: nodes (6 -+ sqrt(6)) / 10, weights 1/9 and (16 +- sqrt(6)) / 36.
    root = 6.0**0.5
    rings = ((1, 0.0, 1.0 / 9.0), (6, (6.0 - root) / 10.0, (16.0 + root) / 36.0), (12, (6.0 + root) / 10.0, (16.0 - root) / 36.0))
    points, weights = [], []
    for count, u, weight in rings:
        angle = 2.0 * np.pi * (np.arange(count) + 0.5 * (count == 12)) / count
        points.append(u**0.5 * np.column_stack([np.cos(angle), np.sin(angle)]))
        weights.append(np.full(count, weight / count))
    return np.vstack(points), np.concatenate(weights)
