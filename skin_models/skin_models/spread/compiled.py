"""Spread and transfer function for whole-body skin: the same as `SpreadField` and `Transmission`, compiled.

A cell list finds the taxels near a contact, the kernel is a table over the distance, and only taxels that were reached and have not
settled again are stepped: the cost follows what is touched. The kernel is cut off where it falls below the stated tolerance; what is cut
off is dispersed, so force stays conserved.
"""

import ctypes
from dataclasses import dataclass

import numpy as np

from skin_models.layout import Layout
from skin_models.native import library
from skin_models.spread.contacts import Contacts, disc_points
from skin_models.spread.field import SpreadField
from skin_models.spread.kernels import Kernel
from skin_models.transmission import Transmission

_TABLE = 8192
_MOST_CELLS = 4_000_000


@dataclass(frozen=True, eq=False)
class Step:
    """One sample, N: readings (T,), and what reached no taxel. `readings` is a view that the next step overwrites."""

    readings: np.ndarray
    applied: float
    dispersed: float
    outside: int  # contacts that no taxel is near


class _Skin(ctypes.Structure):
    _fields_ = (
        [("taxels", ctypes.c_int32), ("table_size", ctypes.c_int32), ("cells", ctypes.c_int32 * 3)]
        + [("origin", ctypes.c_double * 3), ("cell", ctypes.c_double)]
        + [(name, ctypes.c_void_p) for name in ("first", "order", "px", "py", "pz", "nx", "ny", "nz", "gain", "table")]
        + [("reach", ctypes.c_double), ("table_reach", ctypes.c_double), ("stretch", ctypes.c_double * 4)]
        + [("a", ctypes.c_double * 4), ("g", ctypes.c_double * 2), ("c", ctypes.c_double * 2)]
        + [("direct", ctypes.c_double), ("settled", ctypes.c_double)]
        + [(name, ctypes.c_void_p) for name in ("taxel", "active", "near", "reading")]
        + [(name, ctypes.c_void_p) for name in ("position", "force", "radius", "scale", "normal", "offsets", "weights")]
        + [("disc_points", ctypes.c_int32), ("active_count", ctypes.c_int32), ("near_count", ctypes.c_int32)]
        + [("stretched", ctypes.c_int32)]
    )


def compiles(kernel: Kernel) -> bool:
    """Whether this kernel has a fast path on this machine."""
    return kernel.straightened() is not None and library("skin_field") is not None


class CompiledSkin:
    """The fast path. Unlike elsewhere its state changes in place: a hundred thousand taxels are not copied at every step."""

    def __init__(self, field: SpreadField, transmission: Transmission | None = None, settled: float = 1e-6) -> None:
        """`transmission` None: the static spread. `settled` (N): a taxel nothing presses on and that answers less is at rest."""
        self.field, self._library = field, library("skin_field")
        self._library.skin_step.restype = ctypes.c_double
        self._library.skin_step.argtypes = (ctypes.c_void_p, ctypes.c_int32)
        self._arrays: dict[str, np.ndarray] = {}
        self._skin = _Skin(taxels=len(field.layout), table_size=_TABLE, settled=settled)
        self._set_cells(field.layout)
        self._set_kernel(field)
        self._set_recursion(transmission)
        self._set_disc()
        self._set_contacts(16)
        self._step, self._address = self._library.skin_step, ctypes.byref(self._skin)

    @property
    def active(self) -> int:
        """How many taxels the last step worked on."""
        return self._skin.active_count

    def reset(self) -> None:
        """Put everything at rest."""
        for name in ("taxel", "reading"):
            self._arrays[name][:] = 0.0
        self._skin.active_count = 0

    def step(self, contacts: Contacts) -> Step:
        """One sample under `contacts`."""
        self.put(contacts.position, contacts.force, contacts.radius, contacts.normal, contacts.depth)
        return self.advance(len(contacts))

    def put(
        self,
        position: np.ndarray,
        force: np.ndarray,
        radius: np.ndarray | float = 0.0,
        normal: np.ndarray | None = None,
        depth: np.ndarray | float = np.nan,
    ) -> None:
        """Set the contacts of the next `advance` without any check, for loops that count microseconds; normals are of unit length. Forces
        may pull, as those of skin that adheres do."""
        n = len(force)
        if n > len(self._arrays["force"]):
            self._set_contacts(2 * n)
        held = self._arrays
        held["position"][:n], held["force"][:n], held["radius"][:n] = position, force, radius
        if normal is not None:
            held["normal"][:n] = normal
        if self.field.kernel.deep:
            held["scale"][:n] = self.field.kernel.scale(depth)
        self._skin.normal = self._normal_address if normal is not None else None

    def advance(self, count: int) -> Step:
        """One sample under the first `count` contacts that were put."""
        felt = self._step(self._address, count)
        applied = float(self._arrays["force"][:count].sum())
        return Step(self._arrays["reading"], applied, applied - felt, count - self._skin.near_count)

    # ---- contacts -------------------------------------------------------------------------------------------

    def _set_contacts(self, capacity: int) -> None:
        for name in ("position", "normal"):
            self._hold(name, np.zeros((capacity, 3)))
        for name, value in (("force", 0.0), ("radius", 0.0), ("scale", 1.0)):
            self._hold(name, np.full(capacity, value))
        self._normal_address = self._skin.normal

    def _set_disc(self) -> None:
        offsets, weights = disc_points()
        self._skin.disc_points = len(weights)
        self._hold("offsets", offsets)
        self._hold("weights", weights)

    # ---- what stays -----------------------------------------------------------------------------------------

    def _hold(self, name: str, array: np.ndarray) -> None:
        """Keep an array alive and point the structure at it."""
        self._arrays[name] = np.ascontiguousarray(array)
        setattr(self._skin, name, self._arrays[name].ctypes.data)

    def _set_cells(self, layout: Layout) -> None:
        low, extent = layout.positions.min(axis=0), np.ptp(layout.positions, axis=0)
        reach = self.field.kernel.reach(self.field.tolerance)
        cell = max(reach / 4.0, 1e-9)
        while np.prod(np.floor(extent / cell) + 1.0) > _MOST_CELLS:
            cell *= 1.5
        cells = np.floor(extent / cell).astype(int) + 1
        index = np.minimum(((layout.positions - low) / cell).astype(int), cells - 1)
        flat = (index[:, 2] * cells[1] + index[:, 1]) * cells[0] + index[:, 0]
        order = np.argsort(flat, kind="stable")
        self._skin.cells[:], self._skin.origin[:], self._skin.cell = cells.tolist(), low.tolist(), cell
        self._hold("first", np.searchsorted(flat[order], np.arange(np.prod(cells) + 1)).astype(np.int32))
        self._hold("order", order.astype(np.int32))
        for names, values in (("px py pz", layout.positions), ("nx ny nz", layout.normals)):
            for name, column in zip(names.split(), values[order].T, strict=True):
                self._hold(name, column)
        self._hold("gain", self.field.gain[order])
        for name, kind in (("taxel", (float, 5)), ("reading", float), ("active", np.int32), ("near", np.int32)):
            self._hold(name, np.zeros(len(layout), kind))

    def _set_kernel(self, field: SpreadField) -> None:
        kernel = field.kernel.at_depth(0.0)
        matrix, radial = kernel.straightened()
        self._skin.reach, self._skin.table_reach = kernel.reach(field.tolerance), radial.reach(field.tolerance)
        self._skin.stretched, self._skin.stretch[:] = not np.array_equal(matrix, np.eye(2)), matrix.ravel().tolist()
        self._hold("table", radial.shape(np.linspace(0.0, self._skin.table_reach, _TABLE)))

    def _set_recursion(self, transmission: Transmission | None) -> None:
        a, g, c, direct = np.zeros((2, 2)), np.zeros(2), np.zeros(2), 1.0
        if transmission is not None:
            small = transmission.matrices
            n = small[1].size
            share = transmission.dispersion.sensed_share  # the field's gain holds it already
            a[:n, :n], g[:n], c[:n], direct = small[0], small[1], small[2] / share, small[3] / share
        self._skin.a[:], self._skin.g[:], self._skin.c[:], self._skin.direct = a.ravel().tolist(), g.tolist(), c.tolist(), direct
