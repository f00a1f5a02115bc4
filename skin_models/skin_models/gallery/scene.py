"""The press that every picture shows, and what the sensors say of it with and without an effect."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import gaussian_filter1d

from skin_models.catalogue import effects
from skin_models.effect import Effect, Place
from skin_models.effects.noise import Noise
from skin_models.effects.time_shift import Scanning
from skin_models.materials import material
from skin_models.model import Model
from skin_models.signals import Motion, motion
from skin_models.spread.bending import Bent
from skin_models.spread.noted import kernel_of

RATE = 400.0  # Hz
PATH_MM = (  # time s, depth mm: a slow press and hold, a minor loop, release, a quick jog in the air, cycles, a deeper press
    (0.0, -0.4), (0.5, -0.4), (1.2, 0.8), (2.6, 0.8), (3.1, 0.45), (3.6, 1.0), (4.6, 1.0), (5.6, -0.4), (5.9, -0.4), (6.0, -3.4),
    (6.1, -3.4), (6.2, -0.4), (6.5, -0.4), (7.0, 1.2), (7.6, 0.1), (8.2, 1.2), (8.8, 0.1), (9.7, 1.7), (10.4, 1.7), (11.6, -0.4),
    (12.2, -0.4),
)  # fmt: skip
SHARES = (1.0, 0.45, 0.12)  # three taxels, the first under the plunger
POSITIONS = ((0.0, 0.0), (4.7e-3, 0.0), (-5.4e-3, 5.4e-3))  # m, where a spread of 5.25 mm gives those
CLOSE_UPS = {  # s: where a cause is best seen
    "adhesion": (4.8, 5.8),
    "dead_zone": (4.95, 5.35),
    "friction": (2.4, 3.8),
    "inertia": (5.7, 6.4),
    "interference": (1.0, 2.8),
    "lag": (6.5, 7.9),
    "noise": (1.0, 2.8),
    "quantization": (6.5, 7.9),
    "time_shift": (6.5, 7.9),
}
LARGER = {  # to be seen at all
    "hysteresis": {"relative": 0.4},
    "lag": {"tau": 0.12},
    "mount_compliance": {"late": 0.04},
    "quantization": {"step_force": 1.5},
    "time_shift": {"delay": 0.08, "jitter": 0.04, "per_taxel": 0.08},
}
NOISE = (Noise(where="load_cell", white=0.04), Noise(where="taxel", white=0.04))  # of a fair sensor, the same with and without


@dataclass(frozen=True)
class Picture:
    """One effect and what it does: time (s), depth (m) and one channel (N) without and with it."""

    effect: Effect
    channel: str
    t: np.ndarray
    depth: np.ndarray
    without: np.ndarray
    with_it: np.ndarray
    close_up: tuple[float, float]  # s, what the trace shows
    profile: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None  # of a spread: distance along x (m), share without and with it

    @property
    def seen(self) -> np.ndarray:
        """Which samples the close-up shows, (N,) of bool."""
        return (self.t >= self.close_up[0]) & (self.t <= self.close_up[1])

    @property
    def faint(self) -> bool:
        """Whether the two traces can hardly be told apart."""
        return float(np.ptp((self.with_it - self.without)[self.seen])) < 0.06 * float(np.ptp(self.without[self.seen]))


def press() -> Motion:
    """The motion of the plunger; corners are rounded over some 30 ms, as by a real drive."""
    corners = np.array(PATH_MM)
    t = np.arange(0.0, corners[-1, 0], 1.0 / RATE)
    return motion(t, gaussian_filter1d(1e-3 * np.interp(t, *corners.T), 0.03 * RATE))


def pictures(say: Callable[[str], None] = lambda stage: None) -> Iterator[Picture]:
    """One picture per effect and form, in the order of the catalogue; an effect of several places is shown at the first. `say` hears of
    each."""
    s, specimen = press(), replace(material("silicone_4mm").model, shares=SHARES, positions=POSITIONS)
    for n, cls in enumerate(effects(), 1):
        e = _example(cls)
        say(f"simulating {n} of {len(effects())} effects: {e.cause}")
        without, with_it = (_channel(replace(specimen, effects=(one, *NOISE)), e, s) for one in (e.absent(), e))
        profile = _profile(e, specimen) if e.place is Place.SPREAD else None
        yield Picture(e, _name(e), s.t, s.x, without, with_it, CLOSE_UPS.get(e.cause, (s.t[0], s.t[-1])), profile)


def _profile(e: Effect, specimen: Model) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The kernel along x under a contact 1 mm deep, without and with an effect of the spread."""
    x, kernel = np.linspace(-16e-3, 16e-3, 321), kernel_of(specimen.notes)
    bent = Bent(kernel, (e,)).at_depth(1e-3)
    return x, kernel.shape(np.abs(x)), bent.shape(bent.distance(x, np.zeros_like(x)))


def _channel(model: Model, e: Effect, s: Motion) -> np.ndarray:
    response = model.simulate(s, seed=1)
    return response.force if not _on_taxels(e) else response.taxels[int(_is_seen_beside(e))]


def _name(e: Effect) -> str:
    if not _on_taxels(e):
        return "applied force"
    return "taxel beside the plunger" if _is_seen_beside(e) else "taxel under the plunger"


def _is_seen_beside(e: Effect) -> bool:
    """Whether an effect leaves the first taxel as it is."""
    return e.place is Place.SPREAD or isinstance(e, Scanning)


def _example(cls: type[Effect]) -> Effect:
    e = cls.typical(next(iter(cls.places)))
    return e.with_values(**{name: value for name, value in LARGER.get(e.cause, {}).items() if name in e.values})


def _on_taxels(e: Effect) -> bool:
    return e.place in (Place.TAXEL, Place.SPREAD) or e.key == ("dead_zone", "skin")
