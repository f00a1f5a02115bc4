"""Recordings of a rig in which something is hidden, and the truth about them."""

from dataclasses import dataclass, field, replace

import numpy as np

from .effect import Context, Fine, Record
from .hidden import RIVALS, Hide, build, complete
from .noise import as_noise
from .protocols import make_path
from .sizing import find_amplitude, rms, visible, visible_in_array
from .skin import Laws, press
from .specimen import draw_specimen

FORCE_STEP = 4.88e-3 * 25 / 8 * 4.44822  # N, thesis eq. 25 with the 12-bit converter
PLUNGER_MM = 9.9
OVER = 10  # integration steps per sample


@dataclass(frozen=True)
class Session:
    """One recording: t (s), x (encoder, m), force (N, compression positive), taxels (T, n) (N), and what `rig.yaml` declares."""

    t: np.ndarray
    x: np.ndarray
    force: np.ndarray
    taxels: np.ndarray
    rig: dict


@dataclass(frozen=True)
class Hidden:
    """The truth of one hidden effect. `visible`: its size over the noise, per session, of force and each taxel."""

    cause: str
    where: str
    form: str
    size: float
    amplitude: float
    visible: list
    channels: list
    rivals: tuple


@dataclass(frozen=True)
class Truth:
    """What is hidden (empty: nothing), and the noise-free signals (`Record`s) with it and without it."""

    hidden: list
    skin: object
    noise: object
    noise_rms: dict
    signals: list
    plain: list
    seed: int
    protocol: str
    given_model: dict | None = None

    @property
    def cause(self):
        return self.hidden[0].cause if self.hidden else None

    @property
    def where(self):
        return self.hidden[0].where if self.hidden else None


@dataclass
class Setup:
    """The rig of one case, shared by its sessions."""

    seed: int
    protocol: str
    skin: object
    noise: object
    rate: float
    encoder_step: float
    taxel_steps: np.ndarray
    cache: dict = field(default_factory=dict)

    @property
    def dt(self):
        return 1 / (self.rate * OVER)

    def steps(self):
        return {"x": self.encoder_step, "force": FORCE_STEP, "taxels": self.taxel_steps, "cut": []}

    def path(self, number):
        if ("path", number) not in self.cache:
            x = make_path(self.protocol, np.random.default_rng([self.seed, 2, number]), self.skin.depth_max, self.rate * OVER)
            self.cache["path", number] = x
        return self.cache["path", number]


def make_sessions(
    cause=None, where=None, form=None, size=1.0, seed=0, protocol="full", n_sessions=3, n_taxels=1, noise="any",
    thickness_mm=None, layout=None, encoder_step_um=1.0, rate=100.0,
):  # fmt: skip
    """Sessions that hide `cause` (a name, a `Hide`, a list of `Hide`, or None), and the `Truth`.

    `size` 1: what the plain model cannot absorb has the noise's RMS, in the first session and the channel that shows it best.
    Raises KeyError for unknown names.
    """
    rng = np.random.default_rng([seed, 1])
    hides = [] if cause in (None, "null") else [Hide(cause, where, form, size)] if isinstance(cause, str) else _listed(cause)
    hides = [complete(h, rng) for h in hides]
    skin = draw_specimen(rng, thickness_mm, n_taxels, layout)
    setup = Setup(seed, protocol, skin, as_noise(noise, rng), rate, 1e-6 * encoder_step_um, 4.88e-3 * skin.slopes)
    context = [Context(np.random.default_rng([seed, 4, i]), skin, h.where, FORCE_STEP, setup.taxel_steps, rate) for i, h in enumerate(hides)]
    effects = [build(h, c) for h, c in zip(hides, context, strict=True)]
    plain = [_run(setup, i, [], noisy=False)[0] for i in range(n_sessions)]
    scaled = [(e, _amplitude(setup, e, h)) for e, h in zip(effects, hides, strict=True)]
    runs = [_run(setup, i, scaled) for i in range(n_sessions)]
    hidden = [_describe(setup, h, e, a, n_sessions, plain) for h, (e, a) in zip(hides, scaled, strict=True)]
    sessions = [Session(noisy.t, noisy.x, noisy.force, noisy.taxels, _declared(setup)) for _, noisy, _ in runs]
    given = _given_model(skin, hides, effects)
    return sessions, Truth(hidden, skin, setup.noise, _noise_rms(setup), [r[0] for r in runs], plain, seed, protocol, given)


def _listed(hides):
    return [hides] if isinstance(hides, Hide) else list(hides)


def _noise_rms(setup):
    level = np.hypot(setup.noise.level, 12**-0.5)
    return {"force": float(level * FORCE_STEP), "taxels": [float(level * s) for s in setup.taxel_steps]}


def _run(setup, number, effects, noisy=True):
    """(clean Record, noisy Record, fine encoder path) of one session with [(effect, amplitude)]."""
    streams = lambda stage: [np.random.default_rng([setup.seed, 5, stage, i, number]) for i in range(len(effects))]  # noqa: E731
    true = setup.path(number)
    tip, laws = true, Laws()
    for (effect, a), rng in zip(effects, streams(0), strict=True):
        tip = effect.tip(tip, setup.dt, a, rng)
        effect.laws(laws, a)
    fine = _fine(setup, number, true, tip, laws)
    said = true
    for (effect, a), rng, rng2 in zip(effects, streams(1), streams(2), strict=True):
        effect.sense(fine, a, rng)
        said = effect.encoder(said, fine.t, a, rng2)
    every = slice(None, None, OVER)
    clean = Record(fine.t[every].copy(), said[every].copy(), fine.force[every].copy(), fine.taxels[:, every].T.copy())
    rough = _measure(setup, number, effects, clean) if noisy else None
    for (effect, a), rng, rng2 in zip(effects, streams(3), streams(4), strict=True):
        effect.analogue(clean, a, rng)
        effect.digital(clean, a, rng2)
    return clean, rough, said


def _fine(setup, number, true, tip, laws):
    skin, dt = setup.skin, setup.dt
    untouched = tip is true and not (laws.elements or laws.rate or laws.pull or laws.mount_stiffness)
    key = ("pressed", number)
    if untouched and key in setup.cache:
        pressed = setup.cache[key]
    else:
        v = np.gradient(tip, dt)
        pressed = press(tip, v, np.gradient(v, dt), dt, skin, laws)
        if untouched:
            setup.cache[key] = pressed
    v = np.gradient(true, dt)
    branch = skin.k1 * pressed.u + skin.b1 * pressed.w + skin.fraction * pressed.added
    t = np.arange(true.size) * dt
    return Fine(t, true, pressed.u, pressed.w, np.gradient(v, dt), pressed.force.copy(), skin.shares()[:, None] * branch, dt, skin)


def _measure(setup, number, effects, clean):
    rough = Record(clean.t.copy(), clean.x.copy(), clean.force.copy(), clean.taxels.copy())
    steps = setup.steps()
    for c in ["force", *range(rough.taxels.shape[1])]:
        noise = setup.noise
        for effect, a in effects:
            noise = effect.noise(c, noise, a)
        rng = np.random.default_rng([setup.seed, 3, number, 0 if c == "force" else 1 + c])
        if c == "force":
            rough.force += noise.draw(rng, rough.force, FORCE_STEP)
        else:
            rough.taxels[:, c] += noise.draw(rng, rough.taxels[:, c], setup.taxel_steps[c])
    for i, (effect, a) in enumerate(effects):
        effect.analogue(rough, a, np.random.default_rng([setup.seed, 5, 3, i, number]))
        steps = effect.steps(steps, a)
    _convert(rough, steps)
    for i, (effect, a) in enumerate(effects):
        effect.digital(rough, a, np.random.default_rng([setup.seed, 5, 4, i, number]))
    return rough


def _convert(record, steps):
    grid = lambda y, s, name: (np.floor(y / s) + 0.5) * s if name in steps["cut"] else np.round(y / s) * s  # noqa: E731
    record.x = grid(record.x, steps["x"], "x")
    record.force = grid(record.force, steps["force"], "force")
    record.taxels = np.column_stack([grid(y, steps["taxels"][i], i) for i, y in enumerate(record.taxels.T)])


def _sizes(setup, number, effect, a):
    """Visible RMS over noise RMS of [force, taxel_0, …] in one session."""
    if effect.by_difference:
        difference = _difference(setup, _run(setup, number, [(effect, a)])[1], _run(setup, number, [])[1])
    else:
        clean, _, said = _run(setup, number, [(effect, a)], noisy=False)
        measure = visible_in_array if effect.static_array and len(setup.skin.positions) > 1 else visible
        difference = measure(clean, said, setup.dt, OVER, setup.skin)
    floor = _noise_rms(setup)
    return [float(rms(difference[0]) / floor["force"]), *(rms(difference[1]) / np.array(floor["taxels"])).tolist()]


def _difference(setup, one, other):
    return one.force - other.force + setup.skin.stiffness * (one.x - other.x), one.taxels - other.taxels


def _amplitude(setup, effect, hide):
    if effect.fixed:
        return 1.0
    return find_amplitude(lambda a: max(_sizes(setup, 0, effect, a)), hide.size)


def _describe(setup, hide, effect, a, n_sessions, plain):
    sizes = [_sizes(setup, i, effect, a) for i in range(n_sessions)]
    names = ["force", *(f"taxel_{i}" for i in range(len(setup.skin.positions)))]
    touched = []
    for name, values in zip(names, np.transpose(sizes), strict=True):
        if max(values) > 0.1 * max(map(max, sizes)) > 0:
            touched.append(name)
    return Hidden(hide.cause, hide.where, hide.form, hide.size, a, sizes, touched, RIVALS.get(hide.cause, ()))


def _given_model(skin, hides, effects):
    for hide, effect in zip(hides, effects, strict=True):
        if hide.cause == "parameters":
            right = np.array([skin.k1, skin.b1, skin.k2, skin.b2])
            return dict(zip(("k1", "b1", "k2", "b2"), (right * effect.factors).tolist(), strict=True))
    return None


def _declared(setup):
    skin = setup.skin
    return {
        "sample_rate_hz": setup.rate, "force_step_n": FORCE_STEP, "taxel_step_n": setup.taxel_steps.tolist(),
        "encoder_step_um": 1e6 * setup.encoder_step, "taxel_positions_mm": (1e3 * skin.positions).tolist(),
        "plunger_diameter_mm": PLUNGER_MM, "skin_thickness_mm": skin.thickness_mm,
    }  # fmt: skip


def without(session, *columns) -> Session:
    """The same session as a poorer test: drop "x" (force to force), "force" or "taxels" (material test)."""
    gone = {c: None for c in columns if c != "taxels"}
    if "taxels" in columns:
        gone["taxels"] = np.empty((session.t.size, 0))
    return replace(session, **gone)
