"""The command at the top of the clone says in a sentence what the system refuses it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[2]


@pytest.mark.skipif(not (TOP / "skin").exists(), reason="the package lies alone")
@pytest.mark.parametrize("forbidden", [False, True])
def test_what_cannot_be_written_is_one_sentence(tmp_path, forbidden):
    if forbidden and os.geteuid() == 0:
        pytest.skip("nothing is forbidden to root")
    for name in ("skin", "requirements.txt", "colcon.meta"):
        shutil.copy(TOP / name, tmp_path)
    if forbidden:
        tmp_path.chmod(0o500)
    else:
        (tmp_path / "log").write_text("a file where the folder of the log should be")
    (tools := tmp_path.parent / f"{tmp_path.name}_tools").mkdir()
    (tools / "colcon").symlink_to(shutil.which("true"))
    env = dict(os.environ, PATH=os.pathsep.join([str(tools), os.environ["PATH"]]))
    done = subprocess.run([sys.executable, tmp_path / "skin", "build"], capture_output=True, text=True, timeout=60, env=env)
    tmp_path.chmod(0o700)
    assert done.returncode == 2 and done.stderr.startswith("skin: ") and done.stderr.count("\n") == 1
    assert str(tmp_path / "log") in done.stderr and ("somebody else" in done.stderr) is forbidden
