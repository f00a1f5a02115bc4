"""How the plunger moves: paths over a fine, even time grid (m, positive into the skin), with details drawn from a seed."""

import numpy as np

FREE_AIR = -0.0003  # m, where the plunger waits off the skin
RECOVERY = 0.16  # s, time a skin needs to follow a leaving plunger; sines and multisines keep contact by it


class Path:
    """A path under construction: pieces are appended from where the last one ended. Unit of depth: the skin's depth limit."""

    def __init__(self, rng, depth_max, rate):
        self.rng, self.scale, self.rate = rng, depth_max, rate
        self.parts, self.at = [np.full(1, FREE_AIR / depth_max)], FREE_AIR / depth_max

    def add(self, piece):
        self.parts.append(np.asarray(piece, float))
        self.at = float(self.parts[-1][-1])
        return self

    def hold(self, seconds):
        return self.add(np.full(max(1, round(seconds * self.rate)), self.at))

    def ramp(self, to, speed):
        """Straight to depth `to` at `speed` (depth units per second)."""
        count = max(2, round(abs(to - self.at) / speed * self.rate))
        return self.add(np.linspace(self.at, to, count + 1)[1:])

    def free(self, seconds=None):
        self.ramp(FREE_AIR / self.scale, 2.0)
        return self.hold(seconds or self.rng.uniform(2.0, 3.0))

    def smooth(self, width=0.06) -> np.ndarray:
        """The whole path in m; a Hann window of `width` s bounds the acceleration as a servo does."""
        path = np.concatenate(self.parts) * self.scale
        window = np.hanning(round(width * self.rate) + 2)[1:-1]
        half = window.size // 2
        padded = np.pad(path, (half, window.size - 1 - half), mode="edge")
        return np.convolve(padded, window / window.sum(), mode="valid")


def triangles(path, peaks, speed, low=None):
    for peak in peaks:
        path.ramp(peak, speed).ramp(-0.05 if low is None else low, speed)


def sine(path, hertz, periods, centre=0.55, amplitude=None):
    """Sine about `centre`, kept in contact unless an amplitude is asked for."""
    omega = 2 * np.pi * hertz
    amplitude = amplitude or min(0.4, 0.9 * centre / np.hypot(1, omega * RECOVERY))
    path.ramp(centre, 1.0).hold(0.3)
    t = np.arange(1, round(periods / hertz * path.rate) + 1) / path.rate
    path.add(centre + amplitude * np.sin(omega * t))


def multisine(path, periods=2, seconds=8.0, top_hertz=3.0, centre=0.55):
    """Odd lines with random phases, every third left out at random; amplitudes fall as 1/f, contact is kept."""
    lines = np.arange(1, int(top_hertz * seconds) + 1, 2)
    lines = lines[[i % 3 != path.rng.integers(3) or i == 0 for i in range(lines.size)]]
    t = np.arange(round(seconds * path.rate)) / path.rate
    phase = 2 * np.pi * np.outer(lines / seconds, t) + path.rng.uniform(0, 2 * np.pi, (lines.size, 1))
    wave = (np.sin(phase) / lines[:, None]).sum(0)
    need = np.max(np.abs(wave) + RECOVERY * np.abs(np.gradient(wave, 1 / path.rate)))
    wave *= min(0.9 * centre / need, 0.4 / np.max(np.abs(wave)))
    path.ramp(centre + wave[0], 1.0)
    path.add(centre + np.tile(wave, periods))


def random_ramps(path, seconds, slowest=0.2, fastest=4.0):
    start = sum(p.size for p in path.parts)
    while sum(p.size for p in path.parts) - start < seconds * path.rate:
        speed = np.exp(path.rng.uniform(np.log(slowest), np.log(fastest)))
        path.ramp(path.rng.uniform(-0.05, 1.0), speed)
        if path.rng.random() < 0.3:
            path.hold(path.rng.uniform(0.1, 0.6))


def holds(path, depths, lengths):
    for depth, seconds in zip(depths, lengths, strict=True):
        path.ramp(depth, 4.0).hold(seconds)


def _full(path):
    rng = path.rng
    top = rng.uniform(0.95, 1.0)
    for peak in top * np.array([0.35, 0.35, 0.6, 0.6, 0.8, 1.0]):  # rising, each new depth is a virgin cycle
        path.ramp(peak, 1.0).ramp(-0.05, 1.0)
    path.ramp(0.8 * top, 1.0).ramp(0.35, 1.0).ramp(0.6, 1.0).ramp(0.2, 1.0).ramp(top, 1.0).ramp(-0.05, 1.0)
    blocks = [
        lambda: [triangles(path, [top] * n, s * rng.uniform(0.8, 1.25)) for s, n in ((0.15, 1), (0.5, 1), (2.5, 2), (8, 3))],
        lambda: (holds(path, (0.35, 0.95, 0.6), rng.uniform(3, 6, 3)), path.ramp(-0.05, 1.0)),
        lambda: [sine(path, f, n) for f, n in ((0.15, 1.5), (0.6, 3), (2.0, 4), (5.0, 6))],
        lambda: multisine(path),
        lambda: random_ramps(path, rng.uniform(7, 10)),
    ]
    for i in rng.permutation(len(blocks)):
        blocks[i]()


def _single_sine(path):
    """The thesis: four periods that just touch the surface."""
    amplitude, hertz = path.rng.uniform(0.3, 0.48), path.rng.uniform(0.1, 0.35)
    path.ramp(0.0, 1.0).hold(0.5)
    t = np.arange(1, round(4 / hertz * path.rate) + 1) / path.rate
    path.add(amplitude * (1 - np.cos(2 * np.pi * hertz * t)))


def _single_rate_triangles(path):
    triangles(path, [path.rng.uniform(0.8, 1.0)] * 8, path.rng.uniform(0.4, 1.5))


def _holds_only(path):
    holds(path, path.rng.uniform(0.3, 1.0, 4), path.rng.uniform(4, 8, 4))


def _steps(path):
    for _ in range(10):
        path.ramp(0.9, 6.0).hold(path.rng.uniform(0.8, 1.5)).ramp(-0.05, 6.0).hold(path.rng.uniform(0.8, 1.5))


def _pyramid(path):
    for level in (*np.linspace(0.15, 1.0, 7), *np.linspace(0.85, 0.0, 7)):
        path.ramp(level, 3.0).hold(1.5)


def _slow_ramps(path):
    triangles(path, (0.5, 0.75, 1.0), path.rng.uniform(0.06, 0.1))


def _random_ramps_only(path):
    random_ramps(path, 40.0)


def _multisine_only(path):
    multisine(path, periods=4)


BODIES = {
    "full": _full, "single_sine": _single_sine, "single_rate_triangles": _single_rate_triangles, "holds_only": _holds_only,
    "steps": _steps, "pyramid": _pyramid, "slow_ramps": _slow_ramps, "random_ramps": _random_ramps_only,
    "multisine_only": _multisine_only, "full_no_free_air": _full,
}  # fmt: skip


def make_path(name, rng, depth_max, rate) -> np.ndarray:
    """Depth (m) every 1/`rate` s of the named protocol. Raises KeyError for a name that is not in `BODIES`."""
    path = Path(rng, depth_max, rate)
    if name != "full_no_free_air":
        path.hold(rng.uniform(2.0, 3.0))
    BODIES[name](path)
    if name != "full_no_free_air":
        path.free()
    return path.smooth()
