"""The command at the top of the clone says in a sentence what the system refuses it."""

import os
import runpy
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


RUN = {
    (): "run PACKAGE EXECUTABLE [ARGS], where PACKAGE is one of: skin_ident, skin_models",
    ("skin_ident",): "run skin_ident EXECUTABLE [ARGS], where EXECUTABLE is one of: diagnose, fit",
    ("skin_idnt", "fit"): 'no package is called "skin_idnt" (did you mean skin_ident?); there are: skin_ident, skin_models',
    ("skin_ident", "fitt"): 'skin_ident has no executable "fitt" (did you mean fit?); there are: diagnose, fit',
    ("rclpy",): 'no package is called "rclpy"; there are: skin_ident, skin_models',
}


@pytest.mark.skipif(not (TOP / "skin").exists(), reason="the package lies alone")
@pytest.mark.parametrize("arguments", RUN)
def test_what_cannot_be_run_is_named_with_what_there_is(tmp_path, arguments):
    for package, name in (("skin_ident", "fit"), ("skin_ident", "diagnose"), ("skin_models", "skin_node")):
        file = tmp_path / package / "lib" / package / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.touch(0o755)
    skin = runpy.run_path(str(TOP / "skin"), run_name="skin")
    skin["run"].__globals__["INSTALL"] = tmp_path
    with pytest.raises(skin["Problem"]) as problem:
        skin["run"](list(arguments), {})
    assert str(problem.value) == RUN[arguments] and problem.value.status == 2
