"""Recordings of a rig in which something is hidden, and the truth about them."""

from dataclasses import dataclass, replace

import numpy as np

from .effect import Context, Effect
from .hidden import RIVALS, Hide, build, complete
from .noise import as_noise
from .rig import FORCE_STEP, OVER, Rig
from .sizing import added, find_amplitude, rms, visible, visible_in_array
from .specimen import draw_specimen


@dataclass(frozen=True)
class Session:
    """One recording: t (s), x (encoder, m), force (N, compression positive), taxels (T, n) (N), and what `rig.yaml` declares."""

    t: np.ndarray
    x: np.ndarray | None
    force: np.ndarray | None
    taxels: np.ndarray
    rig: dict


@dataclass(frozen=True)
class Hidden:
    """The truth of one hidden effect.

    `visible`: its size over the noise, a row for each session, of force and each taxel, hidden alone. `beside`: the most of it, over the
    noise, that the other hidden effects leave in the first session: nothing of what a dead taxel feels. `channels`: those that carry it.
    `rivals`: names for the same equations, or nearly so, that an honest critic may give as alternatives.
    """

    cause: str
    where: str
    form: str
    size: float
    amplitude: float
    visible: list
    channels: list
    rivals: tuple
    effect: object = None
    beside: float = np.inf


@dataclass(frozen=True)
class Truth:
    """What is hidden (empty: nothing), and the noise-free signals (`Record`s) with it and without it, for an oracle."""

    hidden: list
    skin: object
    noise: object
    noise_rms: dict
    signals: list
    plain: list
    seed: int
    protocol: str
    given_model: dict | None = None
    rig: object = None

    @property
    def cause(self):
        """The first hidden cause, or None."""
        return self.hidden[0].cause if self.hidden else None

    @property
    def where(self):
        """Its place, or None."""
        return self.hidden[0].where if self.hidden else None

    @property
    def channels(self):
        """All channels that carry something hidden."""
        return sorted({c for h in self.hidden for c in h.channels})


def make_sessions(
    cause=None, where=None, form=None, size=1.0, seed=0, protocol="full", n_sessions=3, n_taxels=1, noise="any",
    thickness_mm=None, layout=None, encoder_step_um=1.0, rate=100.0, between=0.0, wobble_um=0.3,
    encoder_noise_um=0.0,
):  # fmt: skip
    """Sessions that hide `cause` (a name, a `Hide`, a list of `Hide`, or None), and the `Truth`.

    `size` 1: what the plain model cannot absorb has the noise's RMS, in the first session and the channel that shows it best.
    `protocol`: a name of `protocols.BODIES`; `noise`: a `Noise`, a kind, or "any"; `layout`: "row_14mm", "row_5mm", "aside";
    `between`: log-normal change of the skin from session to session. Equal arguments give equal recordings.
    Raises KeyError for unknown names.
    """
    rng = np.random.default_rng([seed, 1])
    hides = [complete(h, np.random.default_rng([seed, 7, i])) for i, h in enumerate(_listed(cause, where, form, size))]
    skin = draw_specimen(rng, thickness_mm, n_taxels, layout)
    steps = 4.88e-3 * skin.slopes
    micrometres = {"encoder_step": encoder_step_um, "wobble": wobble_um, "jitter": encoder_noise_um}
    lengths = {name: 1e-6 * um for name, um in micrometres.items()}
    rig = Rig(seed, protocol, skin, as_noise(noise, rng), rate, taxel_steps=steps, between=between, **lengths)
    effects = [build(h, Context(rig.stream(4, i), skin, h.where, FORCE_STEP, steps, rate)) for i, h in enumerate(hides)]
    scaled = [(e, _amplitude(rig, e, h)) for e, h in zip(effects, hides, strict=True)]
    cleans = [rig.clean(i, scaled) for i in range(n_sessions)]
    measured = [rig.measure(c[0], i, scaled) for i, c in enumerate(cleans)]
    declared = rig.declared(noise=any(h.cause == "noise" for h in hides))
    sessions = [Session(m.t, m.x, m.force, m.taxels, declared) for m in measured]
    if n_sessions > 1 and any(getattr(e, "kind", None) == "copied_session" for e in effects):
        sessions[1:2] = sessions[:1]
    signals = [rig.finish(c[0], i, scaled) for i, c in enumerate(cleans)]
    plain = [rig.clean(i, [])[0] for i in range(n_sessions)]
    known = list(zip(signals, cleans, strict=True)) if len(hides) == 1 else None
    hidden = [_describe(rig, h, e, a, n_sessions, known) for h, (e, a) in zip(hides, scaled, strict=True)]
    if len(hidden) > 1:
        hidden = [replace(h, beside=_beside(rig, i, scaled, cleans[0][0])) for i, h in enumerate(hidden)]
    given = _given(skin, hides, effects)
    return sessions, Truth(hidden, skin, rig.noise, rig.noise_rms(), signals, plain, seed, protocol, given, rig)


def _listed(cause, where, form, size):
    if cause in (None, "null"):
        return []
    if isinstance(cause, str):
        return [Hide(cause, where, form, size)]
    return [cause] if isinstance(cause, Hide) else list(cause)


def _sizes(rig, number, effect, a, known=None, coarse=1):
    """Visible RMS over noise RMS of [force, taxel_0, …] in one session; `known` = (finished, (clean, said)) saves running it."""
    if effect.by_difference:
        clean = rig.clean(number, [])[0]
        left = added(rig.measure(clean, number, [(effect, a)]), rig.measure(clean, number, []), clean, rig.skin.stiffness)
    else:
        if known is None:
            run = rig.clean(number, [(effect, a)], coarse)
            known = rig.finish(run[0], number, [(effect, a)]), run
        finished, (_, said) = known
        base = rig.base(number, coarse, said)
        if effect.static_array and len(rig.skin.positions) > 1:
            left = visible_in_array(finished, base, OVER // coarse, rig.skin.shares())
        else:
            left = visible(finished, base, OVER // coarse)
    return _over_noise(rig, *left)


def _over_noise(rig, force, taxels):
    """RMS over noise RMS of [force, taxel_0, …]."""
    floor = rig.noise_rms()
    return [float(rms(force) / floor["force"]), *(rms(taxels) / np.array(floor["taxels"])).tolist()]


def _beside(rig, which, scaled, clean):
    """What one of several effects changes in the first session where the others are, over the noise, in the channel with most of it."""
    others = [*scaled[:which], (Effect(), 0.0), *scaled[which + 1 :]]  # in their places: each has random numbers of its own
    alone = rig.clean(0, others)[0]
    if scaled[which][0].by_difference:
        force, taxels = added(rig.measure(clean, 0, scaled), rig.measure(alone, 0, others), clean, rig.skin.stiffness)
    else:
        told, other = rig.finish(clean, 0, scaled), rig.finish(alone, 0, others)
        change = replace(told, force=told.force - other.force, taxels=told.taxels - other.taxels)
        force, taxels = visible(change, rig.base(0, 1), OVER)
    return max(_over_noise(rig, force, taxels))


def _amplitude(rig, effect, hide):
    if effect.fixed:
        return 1.0
    coarse = rig.coarse([effect])
    return find_amplitude(lambda a: max(_sizes(rig, 0, effect, a, coarse=coarse)), hide.size, limit=effect.limit)


def _describe(rig, hide, effect, a, n_sessions, known):
    sizes = [_sizes(rig, i, effect, a, known and known[i]) for i in range(n_sessions)]
    names = ["force", *(f"taxel_{i}" for i in range(len(rig.skin.positions)))]
    largest = np.max(sizes, axis=0)
    touched = [n for n, value in zip(names, largest, strict=True) if value > max(0.1 * largest.max(), 1e-6)]
    return Hidden(hide.cause, hide.where, hide.form, hide.size, a, sizes, touched, RIVALS.get(hide.cause, ()), effect)


def _given(skin, hides, effects):
    """The model that is given with wrong numbers, where that is what is hidden."""
    for hide, effect in zip(hides, effects, strict=True):
        if hide.cause == "parameters":
            right = np.array([skin.k1, skin.b1, skin.k2, skin.b2])
            return dict(zip(("k1", "b1", "k2", "b2"), (right * effect.factors).tolist(), strict=True))
    return None


def without(session, *columns) -> Session:
    """The same session as a poorer test: drop "x" (force to force), "force" or "taxels" (material test)."""
    gone = {c: None for c in columns if c != "taxels"}
    if "taxels" in columns:
        gone["taxels"] = np.empty((session.t.size, 0))
    return replace(session, **gone)
