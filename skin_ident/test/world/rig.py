"""The rig of one case: from the plunger's path through skin, sensors, noise and converters to a record."""

from dataclasses import dataclass, field, replace

import numpy as np

from .effect import Effect, Fine, Record
from .protocols import make_path
from .skin import Laws, press

FORCE_STEP = 4.88e-3 * 25 / 8 * 4.44822  # N, thesis eq. 25 with the 12-bit converter
PLUNGER_MM = 9.9
OVER = 10  # integration steps per sample


@dataclass
class Rig:
    """What all sessions of a case share. `between`: log-normal change of the skin from session to session; `wobble` of the servo in m,
    `jitter` of what the encoder says, white, in m."""

    seed: int
    protocol: str
    skin: object
    noise: object
    rate: float
    encoder_step: float
    taxel_steps: np.ndarray
    between: float = 0.0
    wobble: float = 0.0
    jitter: float = 0.0
    cache: dict = field(default_factory=dict)

    def stream(self, *where):
        """A random stream of its own for each purpose, so that adding an effect changes nothing else."""
        return np.random.default_rng([self.seed, *where])

    def skin_of(self, number):
        """The skin as it is in one session."""
        if not self.between:
            return self.skin
        change = np.exp(self.between * self.stream(6, number).standard_normal(4))
        now = np.array([self.skin.k1, self.skin.b1, self.skin.k2, self.skin.b2]) * change
        return replace(self.skin, **dict(zip(("k1", "b1", "k2", "b2"), now.tolist(), strict=True)))

    def path(self, number, coarse):
        """(x, v, a, dt) of the plunger at the encoder; `coarse` takes every so many of the fine steps."""
        if ("path", number) not in self.cache:
            rng = self.stream(2, number)
            x = make_path(self.protocol, rng, self.skin.depth_max, self.rate * OVER)
            self.cache["path", number] = x + self.wobble * _slow_noise(rng, x.size, self.rate * OVER)
        x, dt = self.cache["path", number][::coarse], coarse / (self.rate * OVER)
        v = np.gradient(x, dt)
        return x, v, np.gradient(v, dt), dt

    @staticmethod
    def coarse(effects):
        """Take every so many fine steps while looking for a size: as few as the effects bear."""
        if any(e.stiff for e in effects) or all(type(e).laws is Effect.laws and type(e).tip is Effect.tip for e in effects):
            return 1  # as it must be, or as it costs nothing
        return 5 if all(type(e).tip is Effect.tip for e in effects) else 2

    def base(self, number, coarse, said=None):
        """The bare skin under the true path, or under what an encoder said."""
        x, v, a, dt = self.path(number, coarse)
        if said is not None and not np.array_equal(said, x):
            v = np.gradient(said, dt)
            return press(said, v, np.gradient(v, dt), dt, self.skin_of(number))
        key = ("base", number, coarse)
        if key not in self.cache:
            self.cache[key] = press(x, v, a, dt, self.skin_of(number))
        return self.cache[key]

    def clean(self, number, effects, coarse=1):
        """(Record, encoder path) without noise and converter, with [(effect, amplitude)] up to the sensors."""
        x, _, a, dt = self.path(number, coarse)
        tip, laws = x, Laws()
        for i, (effect, size) in enumerate(effects):
            tip = effect.tip(tip, dt, size, self.stream(5, 0, i, number))
            effect.laws(laws, size)
        fine = self._fine(number, coarse, tip, laws, a)
        said = x
        for i, (effect, size) in enumerate(effects):
            effect.sense(fine, size, self.stream(5, 1, i, number))
            said = effect.encoder(said, fine.t, size, self.stream(5, 2, i, number))
        every = slice(None, None, OVER // coarse)
        return Record(fine.t[every].copy(), said[every].copy(), fine.force[every].copy(), fine.taxels[:, every].T.copy()), said

    def _fine(self, number, coarse, tip, laws, a):
        x, _, _, dt = self.path(number, coarse)
        skin = self.skin_of(number)
        if np.array_equal(tip, x) and laws == Laws():
            pressed = self.base(number, coarse)
        else:
            v = np.gradient(tip, dt)
            pressed = press(tip, v, np.gradient(v, dt), dt, skin, laws)
        branch = skin.k1 * pressed.u + skin.b1 * pressed.w + skin.fraction * pressed.added
        taxels = skin.shares()[:, None] * branch
        return Fine(np.arange(x.size) * dt, x, pressed.u, pressed.w, a, pressed.force.copy(), taxels, dt, skin)

    def finish(self, record, number, effects):
        """A copy of a clean record after what happens to samples, without noise and converter: the truth as it could be told."""
        out = _copy(record)
        for stage, name in ((3, "analogue"), (4, "digital")):
            for i, (effect, a) in enumerate(effects):
                getattr(effect, name)(out, a, self.stream(5, stage, i, number))
        return out

    def measure(self, record, number, effects):
        """A copy of a clean record as it is measured."""
        out, steps = _copy(record), {"x": self.encoder_step, "force": FORCE_STEP, "taxels": self.taxel_steps, "cut": []}
        self._add_noise(out, number, effects)
        for i, (effect, a) in enumerate(effects):
            effect.analogue(out, a, self.stream(5, 3, i, number))
            steps = effect.steps(steps, a)
        _convert(out, steps)
        for i, (effect, a) in enumerate(effects):
            effect.digital(out, a, self.stream(5, 4, i, number))
        return out

    def _add_noise(self, out, number, effects):
        if out.x is not None:
            out.x += self.jitter * self.stream(6, number).standard_normal(out.x.size)
        for c in ["force", *range(out.taxels.shape[1])]:
            noise = self.noise
            for effect, a in effects:
                noise = effect.noise(c, noise, a)
            if c == "force":
                out.force += noise.draw(self.stream(3, number, 0), out.force, FORCE_STEP)
            else:
                out.taxels[:, c] += noise.draw(self.stream(3, number, 1 + c), out.taxels[:, c], self.taxel_steps[c])

    def noise_rms(self):
        """Noise and converter together with what the encoder's noise comes to: {"force": N, "taxels": [N, …]}."""
        level, skin = np.hypot(self.noise.level, 12**-0.5), self.skin
        force = np.hypot(level * FORCE_STEP, self.jitter * skin.stiffness)
        return {"force": float(force), "taxels": np.hypot(level * self.taxel_steps, self.jitter * skin.k1 * skin.shares()).tolist()}

    def declared(self, noise=False):
        """What `rig.yaml` says; with the noise's level where that is what is wrong."""
        level = {"force_noise_n": self.noise.level * FORCE_STEP, "taxel_noise_n": (self.noise.level * self.taxel_steps).tolist()}
        return (level if noise else {}) | {
            "sample_rate_hz": self.rate, "force_step_n": FORCE_STEP, "taxel_step_n": self.taxel_steps.tolist(),
            "encoder_step_um": 1e6 * self.encoder_step, "taxel_positions_mm": (1e3 * self.skin.positions).tolist(),
            "plunger_diameter_mm": PLUNGER_MM, "skin_thickness_mm": self.skin.thickness_mm,
        }  # fmt: skip


def _copy(record):
    return Record(record.t.copy(), record.x.copy(), record.force.copy(), record.taxels.copy())


def _slow_noise(rng, n, rate):
    """Unit noise below about 4 Hz."""
    knots = np.arange(0, n + rate / 8, rate / 8)
    raw = rng.standard_normal(knots.size)
    from scipy.interpolate import CubicSpline

    return CubicSpline(knots, raw)(np.arange(n))


def _convert(record, steps):
    def grid(y, step, name):
        return (np.floor(y / step) + 0.5) * step if name in steps["cut"] else np.round(y / step) * step

    record.x = grid(record.x, steps["x"], "x")
    record.force = grid(record.force, steps["force"], "force")
    record.taxels = np.column_stack([grid(y, steps["taxels"][i], i) for i, y in enumerate(record.taxels.T)])
