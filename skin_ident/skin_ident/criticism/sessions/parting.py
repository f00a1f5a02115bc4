"""Moments that tell nothing of a model: the plunger may have left the skin behind it, or met it so fast that the force jumps.

Whether skin follows a fast plunger, pulls at it or lags behind differs from skin to skin, and a jump between two samples cannot be known to
better than a sample. Nor do taxels that read nothing of skin which recovers while nothing presses it, as the thesis's model says they do
(eq 32). What is left out does not pass the common low-pass either: the tail of a jump of newtons is more than the noise.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.sessions.session import Session, motion_under, of_recovery
from skin_models.dispersion import Dispersion
from skin_models.parameter import clipped
from skin_models.signals import Motion

JUMP = 0.03  # of the greatest force
JOLTED = 2  # samples, as they were recorded, about such a contact
RECOVERED = 0.003  # of the greatest depth
RECOVERIES = (0.02, 0.03, 0.05, 0.08, 0.12, 0.2, 0.3, 0.5, 0.8)  # s
SHALLOW = 0.1  # of the greatest depth
NOTHING = 0.4  # of what recovering skin would press on its taxels
PARTING = 1.4  # times the recovery time of the fitted skin within which it counts as left behind
UNSEEN = 0.045  # of the magnitude of the common band's kernel, which may fall on what is left out


def without_parting(session: Session, skin: Dispersion) -> Session:
    """The session less those moments, for skin about like `skin`."""
    return _blind(session, _left_behind(session, skin) if session.drive is None else _unpressed(session, skin))


def without_meeting_at(session: Session, surface: float, skin: Dispersion) -> Session:
    """The session less the moments at which skin about like `skin` would be met or left if its surface lay at this depth, m."""
    return _blind(session, _left_behind(moved(session, surface), skin))


def moved(session: Session, surface: float) -> Session:
    """The session with its depth counted from this surface, m."""
    return replace(session, motion=replace(session.motion, x=session.motion.x - surface))


def _blind(session: Session, left_out: np.ndarray) -> Session:
    """The session less the samples `left_out` (N,), and those with which the common low-pass would mix them."""
    band = session.band.blind(left_out)
    kept = band.misses < UNSEEN
    return replace(session, band=band, measured=band.thin(session.bridged), weight=session.weight * kept)


def beside_partings(session: Session, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of the samples about those moments which the common low-pass would mix with them: where they hold a whole movement, what a
    model says of it was not fitted to anything."""
    kept = without_parting(session, skin).weight
    return np.interp(session.motion.t, session.t, np.any((session.weight > 0.0) & (kept == 0.0), axis=0)) > 0.5


def _left_behind(session: Session, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of the samples to leave out where depth drives the test."""
    s, slow = session.motion, _slower(skin, PARTING)
    left_out = parted(s, skin) | impacts(s, skin, int(np.ceil(JOLTED * session.period / s.dt)))
    surface = slow.surface(s)
    above = ~surface.touched & (surface.depth > RECOVERED * s.x.max())
    return left_out | above if (above & ~left_out).any() and _silent(session, skin) else left_out


def _silent(session: Session, skin: Dispersion) -> bool:
    """Whether taxels read nothing of `skin` above which the plunger is in the air."""
    surface, s = skin.surface(session.motion), session.motion
    if not (skin.recovery and session.n_taxels):
        return False
    speed = np.where(surface.touched, s.v, -surface.depth / skin.recovery)
    free = (s.x <= 0.0) & (surface.depth > 0.02 * s.x.max())
    told = _by_load(session, np.array([surface.depth, speed]), surface.touched)
    return _reads_nothing(session, told, free)


def _unpressed(session: Session, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of the samples to leave out where force drives the test: skin recovers, and its taxels, of the recovery time that explains
    best what they read under load, tell nothing of it."""
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
    """Mask (N,) of samples at which skin is deeper than its force would keep it, by a share `depth` of the greatest depth, under less than
    a share `force` of the greatest force."""
    x = motion_under(session, skin).x
    return (session.drive < force * session.drive.max()) & (x - session.drive / (skin.k1 + skin.k2) > depth * x.max())


def _by_load(session: Session, under: np.ndarray, pressed: np.ndarray) -> np.ndarray:
    """What taxels (T, N) would read as that linear function of depth and speed (2, N) which they are where they are `pressed` (N,)."""
    return np.linalg.lstsq(under[:, pressed].T, _taxels(session)[:, pressed].T, rcond=None)[0].T @ under


def _reads_nothing(session: Session, told: np.ndarray, free: np.ndarray) -> bool:
    """Whether taxels read less than a share `NOTHING` of what recovering skin would press on them, `told` (T, N), at samples `free`."""
    return bool(np.sum((_taxels(session) * told)[:, free]) < NOTHING * np.sum(told[:, free] ** 2))


def _taxels(session: Session) -> np.ndarray:
    return session.bridged[session.taxel_rows]


def _slower(skin: Dispersion, times: float) -> Dispersion:
    return replace(skin, **clipped(Dispersion, b1=times * max(skin.b1, 0.0), b2=times * max(skin.b2, 0.0)))


def parted(s: Motion, skin: Dispersion) -> np.ndarray:
    """Mask (N,) of samples below the surface at which skin that recovers a little slower than the fitted one would not be touched."""
    return (s.x > 0.0) & ~_slower(skin, PARTING).contact(s)


def impacts(s: Motion, skin: Dispersion, beside: int) -> np.ndarray:
    """Mask (N,) of samples up to so many `beside` a contact made or lost at a speed whose damping force alone is more than `JUMP` of the
    greatest force."""
    greatest = (skin.k1 + skin.k2) * max(float(s.x.max()), 1e-9)
    fast = np.abs((skin.b1 + skin.b2) * s.v) > JUMP * greatest
    touching = (s.x > 0.0) & ~parted(s, skin)
    edges = np.diff(touching.astype(int), prepend=int(touching[0])) != 0
    return np.convolve(edges & fast, np.ones(2 * beside + 1), mode="same") > 0.5


def meeting(s: Motion, skin: Dispersion, around: int = 8) -> np.ndarray:
    """Mask (N,) of samples within `around` of shallow or parted contact, where a force may really jump."""
    shallow = (s.x > -SHALLOW * s.x.max()) & (s.x < SHALLOW * s.x.max())
    return np.convolve(shallow | parted(s, _slower(skin, 2.0)), np.ones(2 * around + 1), mode="same") > 0.5
