"""Ten minutes at 1 kHz (force, encoder, 64 taxels: 1.8 million messages) from MCAP into arrays: ours beside what one would take instead.

    bench_reading.py [--seconds 600] [--folder DIR] [--repeat 3] [--only "read alone" rerun …]        (./skin bench reading: as it stands)

Times are medians of the repetitions, each in a process of its own: by the clock on the wall, and by the processor, which does not mind a
busy machine. Ratios are of both. Memory is the process's peak beyond what it held after reading a small file. `read alone` fetches the file
and decompresses its chunks; `read, checked` also takes the checksums that the chunks carry (eight times as quick with zlib-ng installed).
What is not installed is named as such, and what fails by its own last line. `ours` reads on two threads, of which a machine without an idle
core gives it one.
"""

import argparse
import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

CONTENDERS = ("read alone", "read, checked", "ours: arrays", "ours: load", "rerun", "rosbags", "mcap")
SLOW = ("rosbags", "mcap")  # measured once


def chunks(path: Path) -> Iterator[memoryview]:
    """The records of all chunks as they are on disk, one after the other in one buffer."""
    from skin_ident.recordings.mcap_file import survey

    found = survey(path)
    with path.open("rb", buffering=0) as file:
        buffer = bytearray(max(length for _, length in found.chunks))
        for offset, length in found.chunks:
            file.seek(offset)
            body = memoryview(buffer)[:length]
            file.readinto(body)
            yield body


def read_alone(path: Path) -> None:
    """Fetch and decompress, nothing else."""
    from skin_ident.recordings.mcap_chunk import decompress, string

    for body in chunks(path):
        size = int.from_bytes(body[25:33], "little")
        name, at = string(body, 37)
        packed = int.from_bytes(body[at : at + 8], "little")
        decompress(name, body[at + 8 : at + 8 + packed], size)


def read_checked(path: Path) -> None:
    """The same with the checksums, by which a flipped bit is found."""
    from skin_ident.recordings.mcap_chunk import open_chunk

    for body in chunks(path):
        open_chunk(body[9:])


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


def measured(name: str, path: Path) -> tuple[float, float, float] | str:
    """Seconds by the wall's clock and of the processor, and peak memory (MB), in a process of its own; why not, if it cannot run."""
    done = subprocess.run([sys.executable, __file__, "--one", name, "--path", path], capture_output=True, text=True)
    if done.returncode == 0:
        return tuple(json.loads(done.stdout))
    said = done.stderr.strip().splitlines()
    last = said[-1] if said else f"ended with status {done.returncode}"
    missing = last.startswith("ModuleNotFoundError")
    return f"not installed: {last.partition(': ')[2]}" if missing else f"failed: {last}"


def one(name: str, path: Path) -> None:
    """Run one contender and print what it took."""
    import resource

    contender = {
        "read alone": read_alone,
        "read, checked": read_checked,
        "ours: arrays": ours_arrays,
        "ours: load": ours_load,
        "rerun": rerun,
        "rosbags": rosbags,
        "mcap": mcap,
    }[name]
    small = path.with_name("small.mcap")
    contender(small)  # imports, decoders, the page cache of the code
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    begin, worked = time.perf_counter(), time.process_time()
    contender(path)
    took = [time.perf_counter() - begin, time.process_time() - worked]
    print(json.dumps([*took, (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1e3]))


def main() -> None:
    """Make the bags, print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--repeat", type=int, default=3)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--only", nargs="+", default=list(CONTENDERS), choices=CONTENDERS)
    parser.add_argument("--one")
    parser.add_argument("--path", type=Path)
    chosen = parser.parse_args()
    if chosen.one:
        one(chosen.one, chosen.path)
        return
    from make_big_bag import make

    with tempfile.TemporaryDirectory() as temporary:
        folder = chosen.folder or Path(temporary)
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            parser.error(f"--folder {folder}: {error.strerror}")
        for compression in ("NONE", "LZ4", "ZSTD"):
            path, small = folder / f"{compression}_{chosen.seconds:g}s.mcap", folder / "small.mcap"
            if not path.exists():  # whole or not at all: a call that was interrupted must not leave half a bag for the next one
                make(path.with_suffix(".partial"), compression, chosen.seconds).replace(path)
            make(small, compression, 0.5)
            arrays = 8 * 1000 * chosen.seconds * (64 + 2 + 3 * 2) / 1e6
            size = path.stat().st_size / 1e6
            print(f"\n{compression.lower()}: {size:.0f} MB, {3000 * chosen.seconds:.0f} messages, arrays {arrays:.0f} MB", flush=True)
            table(path, chosen.only, chosen.repeat, arrays)


def table(path: Path, names: list[str], repeat: int, arrays: float) -> None:
    """One line per contender, with how many times ours is quicker; contenders take turns, so that a busy spell meets all of them."""
    runs: dict[str, list] = {name: [] for name in dict.fromkeys(["ours: arrays", *names])}
    for turn in range(repeat):
        for name, done in runs.items():
            if turn == 0 or (name not in SLOW and not isinstance(done[0], str)):
                done.append(measured(name, path))
    print(f"  {'':<14} {'wall':>10} {'processor':>12} {'memory':>11} {'of arrays':>10}   times ours (wall, processor)")
    ours = None
    for name, done in runs.items():
        failures = [turn for turn in done if isinstance(turn, str)]
        if failures:
            print(f"  {name:<14} {failures[0]}", flush=True)
            continue
        wall, worked, memory = (statistics.median(column) for column in zip(*done, strict=True))
        ours = ours or (wall, worked)
        ratios = f"{wall / ours[0]:6.2f} {worked / ours[1]:6.2f}"
        print(f"  {name:<14} {wall:8.3f} s {worked:10.3f} s {memory:8.0f} MB {memory / arrays:9.2f}    {ratios}", flush=True)


if __name__ == "__main__":
    main()
