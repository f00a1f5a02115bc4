"""MuJoCo scenes for bench_spread: a slab with taxels under ten balls, in the three ways that MuJoCo offers."""

import time

import mujoco
import numpy as np

PITCH, BALLS, RADIUS = 5e-3, 10, 0.01


def _balls(half: float, top: float, bits: str = "") -> str:
    at = np.random.default_rng(0).uniform(-0.8 * half, 0.8 * half, (BALLS, 2))
    ball = '<body pos="{} {} {}"><joint type="slide" axis="0 0 1"/><joint type="slide" axis="1 0 0"/><geom size="{}" mass="0.3" {}/></body>'
    return "".join(ball.format(x, y, top + RADIUS, RADIUS, bits) for x, y in at)


def _world(content: str, sensors: str, asset: str = "") -> str:
    asset = f"<asset>{asset}</asset>" if asset else ""
    return f'<mujoco><option timestep="0.001"/>{asset}<worldbody>{content}</worldbody><sensor>{sensors}</sensor></mujoco>'


def _grid(side: int) -> tuple[np.ndarray, float]:
    half = (side - 1) / 2 * PITCH
    return np.stack(np.meshgrid(np.linspace(-half, half, side), np.linspace(-half, half, side)), axis=-1).reshape(-1, 2), half


def touch_sites(side: int = 32) -> str:
    """A touch sensor per taxel: it sums the contact forces whose point lies in its site."""
    at, half = _grid(side)
    site = '<site name="t{}" pos="{} {} 0.002" size="{h} {h} 0.003" type="box"/>'
    sites = "".join(site.format(i, x, y, h=PITCH / 2) for i, (x, y) in enumerate(at))
    slab = f'<body>{sites}<geom type="box" size="{half + PITCH} {half + PITCH} 0.002"/></body>'
    return _world(slab + _balls(half, 0.002), "".join(f'<touch site="t{i}"/>' for i in range(len(at))))


def tactile_sensor(side: int = 100) -> str:
    """The tactile sensor: a depth per vertex of a mesh that lies on the slab."""
    at, half = _grid(side)
    i = np.arange(side * side).reshape(side, side)
    a, b, c, d = (i[:-1, :-1], i[:-1, 1:], i[1:, :-1], i[1:, 1:])
    faces = np.concatenate([np.stack([a, b, c], -1).reshape(-1), np.stack([b, d, c], -1).reshape(-1)])
    vertices = np.column_stack([at, np.zeros(len(at))]).reshape(-1)
    words = (" ".join(f"{v:g}" for v in values) for values in (vertices, faces))
    mesh = '<mesh name="pad" vertex="{}" face="{}" inertia="shell"/>'.format(*words)
    slab = f'<geom name="slab" type="box" size="{half} {half} 0.002"/>'
    return _world(slab + _balls(half, 0.002), '<tactile geom="slab" mesh="pad"/>', mesh)


def sprung_bodies(side: int = 32) -> str:
    """A sprung body per taxel: its displacement is the reading."""
    at, half = _grid(side)
    body = (
        '<body pos="{} {} 0"><joint name="t{}" type="slide" axis="0 0 1" stiffness="1000" damping="5"/>'
        '<geom type="box" size="{h} {h} 0.001" mass="0.0005" contype="1" conaffinity="2"/></body>'
    )
    bodies = "".join(body.format(x, y, i, h=0.45 * PITCH) for i, (x, y) in enumerate(at))
    balls = _balls(half, 0.001, 'contype="2" conaffinity="1"')
    return _world(bodies + balls, "".join(f'<jointpos joint="t{i}"/>' for i in range(len(at))))


WAYS = {
    "MuJoCo touch sites": touch_sites,
    "MuJoCo tactile sensor (depth only)": tactile_sensor,
    "MuJoCo sprung bodies": sprung_bodies,
}


def rate_of(scene) -> tuple[int, float, int]:
    """Taxels, steps per second of processor time, and how many taxels respond."""
    model = mujoco.MjModel.from_xml_string(scene())
    data = mujoco.MjData(model)
    for _ in range(100):
        mujoco.mj_step(model, data)
    start, steps = time.process_time(), 0
    while (spent := time.process_time() - start) < 1.0:
        mujoco.mj_step(model, data)
        steps += 1
    taxels = data.sensordata.reshape(3, -1)[0] if "tactile" in scene.__name__ else data.sensordata
    pressed = np.abs(taxels - np.median(taxels)) > 1e-6  # sprung bodies sag under their weight
    return taxels.size, steps / spent, int(np.count_nonzero(pressed))
