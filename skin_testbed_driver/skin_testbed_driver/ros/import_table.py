"""Make a recording of a table: a rosbag2 directory with `encoder`, `force` and what `taxels` there are, that replays like any other.

    ros2 run skin_testbed_driver import_table session_1.tsv --out session_1

The table has the columns t_s, x_mm, force_n, taxel_0_n, …, as export_table writes it, and is read as `fit` reads it; warnings tell what
was mended in it. Stamps begin at --start (seconds since 1970; default: when the table was written). Exit status 2 where that is not
possible.
"""

import argparse
import os
import shutil
import sys
from pathlib import Path

import numpy as np
from geometry_msgs.msg import WrenchStamped
from sensor_msgs.msg import JointState
from skin_testbed_msgs.msg import TaxelArray

from skin_models.errors import SkinError
from skin_models.words import counted
from skin_testbed_driver.bag import BagError, BagWriter, TopicInfo
from skin_testbed_driver.rigs.replay import Recorded
from skin_testbed_driver.rigs.table import read_table
from skin_testbed_driver.ros import JOINT
from skin_testbed_driver.ros.definitions import definition
from skin_testbed_driver.ros.packed import Packed

_UNKNOWN = 2  # TaxelArray.STALE: the table has no number there


def import_table(table: Path, directory: Path, start: float | None = None) -> Recorded:
    """Write the bag of a table and return what it held. Raises `RigError`; `BagError` where `directory` exists, or cannot be written, in
    which case nothing is left there."""
    recorded = read_table(table)
    begin = round(1e9 * (table.stat().st_mtime if start is None else start))
    rig, there = _rig_beside(table), directory.exists()
    try:
        bag = BagWriter(directory, kept="nothing of it is kept")
        _write(bag, recorded, begin)
        if rig is not None:
            bag.attach("rig.yaml", "application/yaml", rig, begin)
        bag.close()
    except BaseException:
        if not there:
            shutil.rmtree(directory, ignore_errors=True)  # nothing half written
        raise
    return recorded


def _rig_beside(table: Path) -> bytes | None:
    """The content of the rig.yaml beside a table, or None where there is none. Raises `BagError`."""
    path = table.parent / "rig.yaml"
    try:
        return path.read_bytes() if os.path.lexists(path) else None
    except OSError as error:
        raise BagError(f"cannot read {path}: {error.strerror}") from error


def _write(bag: BagWriter, recorded: Recorded, begin: int) -> None:
    count = recorded.taxels.values.shape[1]
    kinds = {"/encoder": JointState, "/force": WrenchStamped}
    if count:  # arrays of no taxel would say that there is a skin which feels nothing
        kinds["/taxels"] = TaxelArray
    types = {name: f"{kind.__module__.split('.')[0]}/msg/{kind.__name__}" for name, kind in kinds.items()}
    topics = [bag.add_topic(TopicInfo(name, kind, definition(kind))) for name, kind in types.items()]
    encoder_bytes, force_bytes, taxels_bytes = _messages(count)
    rows = zip(recorded.depth.t, recorded.depth.values, recorded.force.values, recorded.taxels.values, strict=True)
    for t, depth, load, sensed in rows:
        now = begin + round(1e9 * (t - recorded.depth.t[0]))
        stamp = divmod(now, 10**9)
        encoder_bytes.with_stamp(stamp).set_number("position", depth)
        force_bytes.with_stamp(stamp).set_number("wrench.force.z", -load)
        status = np.where(np.isnan(sensed), _UNKNOWN, 0).astype(np.uint8)
        taxels_bytes.with_stamp(stamp).set("force", sensed).set("status", status)
        for topic, message in zip(topics, (encoder_bytes, force_bytes, taxels_bytes), strict=False):
            bag.write(topic, message.data(), now, now)


def _messages(count: int) -> tuple[Packed, Packed, Packed]:
    encoder, force = JointState(name=[JOINT], position=[0.0]), WrenchStamped()
    taxels = TaxelArray(force=[0.0] * count, status=[0] * count)
    force.header.frame_id, taxels.header.frame_id = "load_cell", "skin"
    return Packed(encoder, "position", behind=8), Packed(force, "wrench.force.z", behind=24), Packed(taxels, "force", "status")


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="import_table", description="Make a rosbag2 recording of a table.")
    parser.add_argument("table", type=Path, help="t_s, x_mm, force_n, taxel_0_n, …, with tabs, commas or semicolons between")
    parser.add_argument("--out", type=Path, required=True, help="directory of the recording, must not exist")
    parser.add_argument("--start", type=float, help="stamp of the first row, s since 1970; default: when the table was written")
    chosen = parser.parse_args()
    try:
        recorded = import_table(chosen.table, chosen.out, chosen.start)
    except SkinError as error:
        print(f"import_table: {' '.join(str(error).split())}", file=sys.stderr)
        sys.exit(2)
    for warning in recorded.warnings:
        print(f"import_table: {chosen.table}: {warning}", file=sys.stderr)
    print(f"{chosen.out}: {counted(recorded.depth.t.size, 'sample')}")


if __name__ == "__main__":
    main()
