"""Recordings with a known truth, and the files they come in. The equations are written out here, apart from the package's own."""

from pathlib import Path

import numpy as np
from mcap.writer import CompressionType
from mcap.writer import Writer as McapWriter
from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from skin_ident.recordings.recording import Recording

G = 9.80665
SILICONE = {
    2: (0.000216, 1330.0, 25042.0, 590.2, 1603.0),
    4: (0.000432, 939.5, 9619.0, 629.2, 2766.0),
    6: (0.000648, 248.6, 4338.0, 758.3, 5600.0),
}
START_NS = 1_700_000_000_000_000_000
OURS = {
    "skin_testbed_msgs/msg/TaxelArray": "std_msgs/Header header\nfloat64[] force\nfloat64[] voltage\nuint8[] status\n",
    "skin_testbed_msgs/msg/TaxelLayout": (
        "std_msgs/Header header\nstring[] names\ngeometry_msgs/Point[] positions\ngeometry_msgs/Vector3[] normals\nfloat64[] area\n"
    ),
}


def sine(n=4000, dt=0.01, amplitude=0.3e-3, offset=0.5e-3, hz=0.25):
    """Depth, speed and acceleration (3, n) of the thesis's identification motion."""
    t, w = np.arange(n) * dt, 2 * np.pi * hz
    return np.array([offset + amplitude * np.sin(w * t), amplitude * w * np.cos(w * t), -amplitude * w**2 * np.sin(w * t)])


def response(xva, truth=SILICONE[4], shares=(1.0,), dt=0.01):
    """Force (n,) and taxels (T, n) of eqs 27 and 28, with nothing in the air and no pulling."""
    (x, v, a), (m, b1, k1, b2, k2) = xva, truth
    touched = in_contact(x, v, (b1 + b2) / (k1 + k2), dt)
    sensed = (b1 * v + k1 * x) * touched
    return m * (a - G) * touched + sensed + (b2 * v + k2 * x) * touched, np.multiply.outer(np.array(shares), sensed)


def in_contact(x, v, tau, dt):
    """Skin that would pull lets go; its surface then creeps back with tau until the plunger meets it again."""
    touched, surface, free = np.zeros(x.size, bool), 0.0, False
    for i in range(x.size):
        surface *= np.exp(-dt / tau)
        free = x[i] <= surface if free else x[i] + tau * v[i] <= 0
        touched[i] = x[i] > 0 and not free
        surface = x[i] if touched[i] else surface
    return touched


def noise(rng, n, sigma, rho=0.0):
    """White, or AR(1) noise with standard deviation sigma."""
    from scipy.signal import lfilter

    w = rng.normal(size=n + 2000) * sigma * np.sqrt(1 - rho**2)
    return lfilter([1.0], [1.0, -rho], w)[2000:]


def recording(seed=0, truth=SILICONE[4], shares=(1.0,), sigma=0.05, rho=0.0, encoder=0.0, name="made", dt=0.01, **motion):
    """A session as it would be read."""
    rng = np.random.default_rng(seed)
    xva = sine(dt=dt, **motion)
    force, taxels = response(xva, truth, shares, dt)
    n = force.size
    return Recording(
        name=name,
        t=np.arange(n) * dt,
        depth=xva[0] + encoder * rng.normal(size=n),
        force=force + noise(rng, n, sigma, rho),
        taxels=np.array([y + noise(rng, n, sigma, rho) for y in taxels]),
    )


def typestore():
    """Jazzy's types and ours."""
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in OURS.items():
        store.register(get_types_from_msg(text, name))
    return store


KINDS = {
    "/encoder": "sensor_msgs/msg/JointState",
    "/force": "geometry_msgs/msg/WrenchStamped",
    "/taxels": "skin_testbed_msgs/msg/TaxelArray",
}


def serialised(r: Recording, stamps_ns=None, log_delay_ns=1500, change=None):
    """Every message of a recording as (topic, log time in ns, bytes); `change(store, i, message)` may alter it."""
    store = typestore()
    ns = START_NS + np.rint(r.t * 1e9).astype(np.int64) if stamps_ns is None else stamps_ns
    for i, stamp in enumerate(ns.tolist()):
        for k, (topic, message) in enumerate(messages(store, r, i, stamp).items()):
            message = message if change is None else change(store, i, message)
            yield topic, stamp + log_delay_ns * (k + 1), bytes(store.serialize_cdr(message, KINDS[topic]))


def write_bag(path: Path, r: Recording, storage="mcap", mode=None, **how):
    """A rosbag2 directory of the recording with our types, by rosbags' own writer; `mode` compresses whole files or single messages."""
    plugin = StoragePlugin.MCAP if storage == "mcap" else StoragePlugin.SQLITE3
    writer = Writer(path, version=9, storage_plugin=plugin)
    if mode:
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        lines = {topic: writer.add_connection(topic, kind, typestore=typestore()) for topic, kind in KINDS.items()}
        for topic, log_ns, data in serialised(r, **how):
            writer.write(lines[topic], log_ns, data)
    return path


def write_mcap(path: Path, r: Recording, compression="NONE", chunk_size=20_000, use_chunking=True, **how):
    """A bare .mcap of the same, in small chunks, by the mcap library."""
    store = typestore()
    with path.open("wb") as file:
        writer = McapWriter(file, chunk_size=chunk_size, compression=CompressionType[compression], use_chunking=use_chunking)
        writer.start("ros2", "test")
        lines = {}
        for topic, kind in KINDS.items():
            text = store.generate_msgdef(kind, ros_version=2)[0].encode()
            lines[topic] = writer.register_channel(topic, "cdr", writer.register_schema(kind, "ros2msg", text))
        for topic, log_ns, data in serialised(r, **how):
            writer.add_message(lines[topic], log_ns, data, log_ns)
        writer.finish()
    return path


def messages(store, r: Recording, i: int, stamp: int):
    """The three messages of one sample."""
    t = store.types
    zero = np.array([])

    def header(frame):
        return t["std_msgs/msg/Header"](t["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9), frame)

    vector = t["geometry_msgs/msg/Vector3"]
    wrench = t["geometry_msgs/msg/Wrench"](vector(0.0, 0.0, -r.force[i]), vector(0.0, 0.0, 0.0))
    status = np.zeros(len(r.taxels), np.uint8)
    return {
        "/encoder": t["sensor_msgs/msg/JointState"](header("rig"), ["indentation"], r.depth[i : i + 1], zero, zero),
        "/force": t["geometry_msgs/msg/WrenchStamped"](header("load_cell"), wrench),
        "/taxels": t["skin_testbed_msgs/msg/TaxelArray"](header("skin"), r.taxels[:, i].copy(), zero, status),
    }


def write_table(path: Path, r: Recording, mark=","):
    """A table with units in its header."""
    names = ["t_s", "x_mm", "force_n", *(f"taxel_{i}_n" for i in range(len(r.taxels)))]
    rows = np.vstack([r.t, 1e3 * r.depth, r.force, r.taxels]).T
    lines = [mark.join(names), *(mark.join(f"{v:.9g}" for v in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n")
    return path


def same(a, b, tolerance=1e-8):
    """Whether two recordings hold the same depth, force and taxels."""
    return all(np.allclose(getattr(a, k), getattr(b, k), rtol=tolerance, atol=1e-12) for k in ("depth", "force", "taxels"))
