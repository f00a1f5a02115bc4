"""Leaves out moments that say nothing about a model: where the plunger may have left the skin behind, or met it so fast that the force
jumps.

Skins differ in whether they follow a fast plunger, pull at it or lag behind, and a jump between two samples is known in time only to within
a sample. The same holds where taxels do not read the recovery of skin that nothing presses, though in the thesis's model they do (eq 32).
The samples left out do not enter the common low-pass either: the tail of a jump of newtons exceeds the noise.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session, motion_under, of_recovery
from skin_models.dispersion import Dispersion
from skin_models.parameter import clipped
from skin_models.signals import Motion

JUMP = 0.03  # share of the greatest force
JOLTED = 2  # recorded samples to either side of a contact met at such a jump
RECOVERED = 0.003  # share of the greatest depth, from which unloaded skin counts as not recovered
RECOVERIES = (0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.5, 0.8)  # s, recovery times that are tried
SHALLOW = 0.1  # share of the greatest depth
AROUND = 8  # samples to either side of shallow contact that belong to it
NOTHING = 0.4  # share of the recovery signal, below which taxels do not read it
PARTING = 1.4  # factor on the fitted skin's recovery time, so that skin somewhat slower is allowed for
UNSEEN = 0.045  # share of the common kernel's magnitude that may fall on left-out samples


def without_parting(session: Session, skin: Dispersion) -> Session:
    """The session without the moments at which the plunger may have left skin like `skin`, or met it at a jump."""
    return _blind(session, _left_behind(session, skin) if session.drive is None else _unpressed(session, skin))


def without_meeting_at(session: Session, surface: float, skin: Dispersion) -> Session:
    """The session without the moments at which skin like `skin` would be met or left if its surface lay at depth `surface`, m."""
    return _blind(session, _left_behind(moved(session, surface), skin))


def moved(session: Session, surface: float) -> Session:
    """The session with its depth counted from `surface`, m."""
    return replace(session, motion=replace(session.motion, x=session.motion.x - surface))


def _blind(session: Session, left_out: np.ndarray) -> Session:
    """The session without the samples `left_out` (N,) and those that the common low-pass would mix with them."""
    band = session.band.blind(left_out)
    kept = band.misses < UNSEEN
    return replace(session, band=band, measured=band.thin(session.bridged), weight=session.weight * kept)


def beside_partings(session: Session, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of samples near partings that were dropped because the common low-pass would mix them with left-out ones. If a whole
    movement lies there, the model was never fitted to it."""
    kept = without_parting(session, skin).weight
    return np.interp(session.motion.t, session.t, np.any((session.weight > 0.0) & (kept == 0.0), axis=0)) > 0.5


def _left_behind(session: Session, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of the samples to leave out in a test driven by depth: parted contacts, impacts, and, where taxels do not read it, the
    recovery of skin below a plunger in the air."""
    s, slow = session.motion, _slower(skin, PARTING)
    left_out = parted(s, skin) | impacts(s, skin, int(np.ceil(JOLTED * session.period / s.dt)))
    surface = slow.surface(s)
    above = ~surface.touched & (surface.depth > RECOVERED * s.x.max())
    return left_out | above if (above & ~left_out).any() and _silent(session, skin) else left_out


def _silent(session: Session, skin: Dispersion) -> bool:
    """Whether the taxels read nothing of the recovery of `skin` while the plunger is in the air."""
    surface, s = skin.surface(session.motion), session.motion
    if not (skin.recovery and session.n_taxels):
        return False
    speed = np.where(surface.touched, s.v, -surface.depth / skin.recovery)
    free = (s.x <= 0.0) & (surface.depth > 0.02 * s.x.max())
    told = _by_load(session, np.array([surface.depth, speed]), surface.touched)
    return _reads_nothing(session, told, free)


def _unpressed(session: Session, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of the samples to leave out in a test driven by force: those where `skin` still recovers under hardly any force, if the
    taxels do not read such a recovery. Whether they do is tested with the recovery time that best explains their readings under load."""
    pressed = session.drive > JUMP * session.drive.max()
    fits = []
    for tau in RECOVERIES:
        like = of_recovery(tau)
        moved = motion_under(session, like)
        told = _by_load(session, np.array([moved.x, moved.v]), pressed)
        fits.append((float(np.sum((_taxels(session) - told)[:, pressed] ** 2)), told, like))
    _, told, like = min(fits, key=lambda fit: fit[0])
    silent = _reads_nothing(session, told, _recovering(session, like, 0.01, 0.02))
    return _recovering(session, skin, JUMP, RECOVERED) & silent


def _recovering(session: Session, skin: Dispersion, force: float, depth: float) -> np.ndarray:
    """Mask (N,) of samples under less than a share `force` of the greatest force, where skin is deeper than that force would hold it by
    more than a share `depth` of the greatest depth."""
    x = motion_under(session, skin).x
    return (session.drive < force * session.drive.max()) & (x - session.drive / (skin.k1 + skin.k2) > depth * x.max())


def _by_load(session: Session, under: np.ndarray, pressed: np.ndarray) -> np.ndarray:
    """Readings (T, N) predicted by a linear function of depth and speed `under` (2, N), fitted to the taxels where they are `pressed`
    (N,)."""
    return np.linalg.lstsq(under[:, pressed].T, _taxels(session)[:, pressed].T, rcond=None)[0].T @ under


def _reads_nothing(session: Session, told: np.ndarray, free: np.ndarray) -> bool:
    """Whether the taxels, at samples `free`, read less than a share `NOTHING` of `told` (T, N), the readings predicted for recovering
    skin."""
    return bool(np.sum((_taxels(session) * told)[:, free]) < NOTHING * np.sum(told[:, free] ** 2))


def _taxels(session: Session) -> np.ndarray:
    return session.bridged[session.taxel_rows]


def _slower(skin: Dispersion, times: float) -> Dispersion:
    return replace(skin, **clipped(Dispersion, b1=times * max(skin.b1, 0.0), b2=times * max(skin.b2, 0.0)))


def parted(s: Motion, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of samples at positive depth at which skin that recovers somewhat slower than the fitted one would have lost contact."""
    return (s.x > 0.0) & ~_slower(skin, PARTING).contact(s)


def impacts(s: Motion, skin: Dispersion, beside: int) -> np.ndarray:
    """Mask (N,) of samples up to `beside` samples from a contact made or lost at a speed whose damping force alone exceeds `JUMP` of the
    greatest force."""
    greatest = (skin.k1 + skin.k2) * max(float(s.x.max()), 1e-9)
    fast = np.abs((skin.b1 + skin.b2) * s.v) > JUMP * greatest
    touching = (s.x > 0.0) & ~parted(s, skin)
    edges = np.diff(touching.astype(int), prepend=int(touching[0])) != 0
    return np.convolve(edges & fast, np.ones(2 * beside + 1), mode="same") > 0.5


def meeting(s: Motion, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of samples within `AROUND` samples of shallow or parted contact, where a real force may jump."""
    shallow = (s.x > -SHALLOW * s.x.max()) & (s.x < SHALLOW * s.x.max())
    return np.convolve(shallow | parted(s, _slower(skin, 2.0)), np.ones(2 * AROUND + 1), mode="same") > 0.5
