"""Ten minutes at 1 kHz (force, encoder, 64 taxels: 1.8 million messages) from MCAP into arrays: ours beside what one would take instead.

    python bench_reading.py [--seconds 600] [--folder DIR] [--repeat 3]

Times are wall clock, the least of the repetitions, each in a process of its own; memory is that process's peak. `read alone` fetches the
file and decompresses its chunks. rerun and mcap are left out where they are not installed.
"""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

CONTENDERS = ("read alone", "ours: arrays", "ours: load", "rerun", "rosbags", "mcap")


def read_alone(path: Path) -> None:
    """Fetch and decompress, nothing else."""
    from skin_ident.recordings.mcap_chunk import decompress, string
    from skin_ident.recordings.mcap_file import survey

    found = survey(path)
    with path.open("rb", buffering=0) as file:
        buffer = bytearray(max(length for _, length in found.chunks))
        for offset, length in found.chunks:
            file.seek(offset)
            body = memoryview(buffer)[:length]
            file.readinto(body)
            size = int.from_bytes(body[25:33], "little")
            name, at = string(body, 37)
            packed = int.from_bytes(body[at : at + 8], "little")
            decompress(name, body[at + 8 : at + 8 + packed], size)


def ours_arrays(path: Path) -> None:
    """Stamps and values of every topic."""
    from skin_ident.recordings.bag import _read, choose
    from skin_ident.recordings.storage import Storage

    with Storage(path) as bag:
        found, *_ = _read(bag, choose(path.name, bag.topics, {})[0], False)
    assert found["taxels"].rows.shape[0] == 64


def ours_load(path: Path) -> None:
    """The whole way to a checked, evenly sampled recording."""
    from skin_ident.recordings.load import load

    assert load(path)[0].taxels.shape[0] == 64


def rerun(path: Path) -> None:
    """rerun's MCAP reader, the wanted columns turned into numpy arrays."""
    import numpy as np
    import pyarrow as pa
    from rerun.chunk import McapReader

    wanted = {"/force": lambda m: m.field("wrench").field("force").field("z"), "/taxels": lambda m: m.field("force").flatten()}
    out: dict[str, list] = {"/force": [], "/taxels": [], "/encoder/position": []}
    for chunk in McapReader(str(path)).stream():
        if chunk.entity_path not in out or chunk.num_rows < 2:
            continue
        batch = pa.record_batch(chunk.to_record_batch())
        column = next((c for n, c in zip(batch.schema.names, batch.columns, strict=True) if n.endswith((":message", ":scalars"))), None)
        values = wanted.get(chunk.entity_path, lambda m: m)(column.flatten())
        out[chunk.entity_path].append(values.to_numpy(zero_copy_only=False))
    assert all(np.concatenate(rows).size for rows in out.values())


def rosbags(path: Path) -> None:
    """rosbags' reader and decoder into lists, then arrays."""
    import numpy as np
    from rosbags.highlevel import AnyReader

    depth, force, taxels = [], [], []
    with AnyReader([path]) as bag:
        for connection, _, raw in bag.messages():
            m = bag.deserialize(raw, connection.msgtype)
            if connection.topic == "/encoder":
                depth.append((m.header.stamp.sec, m.header.stamp.nanosec, m.position[0]))
            elif connection.topic == "/force":
                force.append((m.header.stamp.sec, m.header.stamp.nanosec, m.wrench.force.z))
            else:
                taxels.append(m.force)
    assert np.array(taxels).shape[1] == 64 and np.array(depth).size == np.array(force).size


def mcap(path: Path) -> None:
    """The mcap library with its ROS 2 decoder."""
    from mcap_ros2.reader import read_ros2_messages

    rows = [m.ros_msg.force for m in read_ros2_messages(str(path), topics=["/taxels"])]
    rest = [m.log_time_ns for m in read_ros2_messages(str(path), topics=["/encoder", "/force"])]
    assert rows and rest


def measured(name: str, path: Path) -> tuple[float, float] | None:
    """Seconds and peak memory above the bare interpreter with its libraries (MB), in a process of its own; None if it cannot run."""
    done = subprocess.run([sys.executable, __file__, "--one", name, "--path", path], capture_output=True, text=True)
    return tuple(json.loads(done.stdout)) if done.returncode == 0 else None


def one(name: str, path: Path) -> None:
    """Run one contender and print what it took."""
    import resource

    contender = {
        "read alone": read_alone,
        "ours: arrays": ours_arrays,
        "ours: load": ours_load,
        "rerun": rerun,
        "rosbags": rosbags,
        "mcap": mcap,
    }[name]
    small = path.with_name("small.mcap")
    contender(small)  # imports, decoders, the page cache of the code
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin = time.perf_counter()
    contender(path)
    print(json.dumps([time.perf_counter() - begin, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e3]))


def main() -> None:
    """Make the bags, print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--one")
    parser.add_argument("--path", type=Path)
    chosen = parser.parse_args()
    if chosen.one:
        one(chosen.one, chosen.path)
        return
    from make_big_bag import make

    with tempfile.TemporaryDirectory() as temporary:
        folder = chosen.folder or Path(temporary)
        for compression in ("NONE", "LZ4", "ZSTD"):
            path, small = folder / f"{compression}.mcap", folder / "small.mcap"
            if not path.exists():
                make(path, compression, chosen.seconds)
            make(small, compression, 0.5)
            arrays = 8 * 1000 * chosen.seconds * (64 + 2 + 3 * 2) / 1e6
            print(
                f"\n{compression.lower()}: {path.stat().st_size / 1e6:.0f} MB, {3000 * chosen.seconds:.0f} messages, arrays {arrays:.0f} MB"
            )
            table(path, chosen.repeat)


def table(path: Path, repeat: int) -> None:
    """One line per contender, with how many times ours is quicker."""
    taken = {}
    for name in CONTENDERS:
        runs = [measured(name, path) for _ in range(repeat if "ours" in name or name == "read alone" else 1)]
        taken[name] = None if None in runs else (min(t for t, _ in runs), max(m for _, m in runs))
        if taken[name] is None:
            print(f"  {name:<14} not installed", flush=True)
            continue
        seconds, memory = taken[name]
        ratio = seconds / taken["ours: arrays"][0] if taken.get("ours: arrays") else float("nan")
        print(f"  {name:<14} {seconds:8.3f} s {memory:8.0f} MB   {ratio:6.1f} x ours", flush=True)


if __name__ == "__main__":
    main()
