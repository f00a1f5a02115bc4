"""Export a recording as the thesis's testbed stored its own: a tab-delimited table, one row per sample (section 3.2.1).

    ros2 run skin_testbed_driver export_table folder/session_1                          # writes session_1.tsv, here
    ros2 run skin_testbed_driver export_table folder/session_1 --out tables/first.tsv

Columns: t_s, x_mm, force_n, taxel_0_n, …; compression is positive, what is not known is nan. `fit`, `diagnose` and rig:=replay read it, and
import_table makes a bag of it again. The table is written into the present folder, not beside the recording, where a fit of the whole
folder would take it for one more session. The recording's rig.yaml comes with it. Of a file that is cut off, what can be read is written,
and a warning tells how much that is. Exit status 2 where nothing can be written.
"""

import argparse
import contextlib
import shutil
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from skin_models.errors import SkinError
from skin_models.words import counted
from skin_testbed_driver.rig import RigError
from skin_testbed_driver.rigs.replay import Recorded
from skin_testbed_driver.rigs.table import write_table
from skin_testbed_driver.ros.replayed_bag import read_bag


def export_table(recording: Path, out: Path, namespace: str = "") -> tuple[Recorded, int, list[Path]]:
    """Write the table of a bag, of its topics in `namespace`, and return what it held, the rows that were written, and the files that hold
    it now.

    Raises `RigError`; an existing file is not overwritten, and a table is not put beside the rig.yaml of another rig.
    """
    rig = (recording if recording.is_dir() else recording.parent) / "rig.yaml"
    beside = out.parent / "rig.yaml"
    if rig.is_file() and beside.is_file() and rig.read_bytes() != beside.read_bytes():
        other = out.parent / f"{out.stem}_table" / out.name
        raise RigError(f"{beside} is of another rig than {rig}: name a table in a folder of its own, such as --out {other}")
    recorded, _ = read_bag(str(recording), namespace)
    with _folder(out.parent):
        rows = write_table(out, recorded)
        if rig.is_file() and not beside.exists():
            shutil.copyfile(rig, beside)
    if beside.exists() and not rig.is_file():
        strange = f"{beside} lies there already and will be read with the table: is it of this rig? The recording has none"
        recorded = replace(recorded, warnings=(*recorded.warnings, strange))
    return recorded, rows, [out, *([beside] if rig.is_file() else [])]


@contextlib.contextmanager
def _folder(folder: Path) -> Iterator[None]:
    """Make `folder` where it is missing; one that stays empty goes again."""
    missing = [p for p in (folder, *folder.parents) if not p.exists()]
    folder.mkdir(parents=True, exist_ok=True)
    try:
        yield
    except BaseException:
        for made in missing:
            with contextlib.suppress(OSError):
                made.rmdir()
        raise


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(prog="export_table", description="Write a recording as a tab-delimited table.")
    parser.add_argument("recording", type=Path, help="a rosbag2 directory or an .mcap file")
    parser.add_argument("--out", type=Path, help="the table; default: the recording's name with .tsv, in the present folder")
    parser.add_argument("--namespace", default="", help="of the topics, where the recording holds several rigs")
    chosen = parser.parse_args()
    out = chosen.out or Path(chosen.recording.resolve().with_suffix("").name + ".tsv")
    try:
        recorded, rows, written = export_table(chosen.recording, out, chosen.namespace)
    except SkinError as error:
        sys.exit(_complain("export_table", error))
    except OSError as error:
        sys.exit(_complain("export_table", RigError(f"cannot write {out}: {error.strerror}")))
    for warning in recorded.warnings:
        _complain("export_table", warning)
    print(f"{counted(rows, 'sample')}: wrote {' and '.join(str(file.absolute()) for file in written)}")


def _complain(program: str, error: Exception | str) -> int:
    print(f"{program}: {' '.join(str(error).split())}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    main()
