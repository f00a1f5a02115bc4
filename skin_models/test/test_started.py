"""Every installed command ends with one word and status 130 on Ctrl-C, whatever it was doing."""

import importlib.util
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest

TOP = Path(__file__).resolve().parents[2]
PACKAGES = ("skin_models", "skin_motion_profiles", "skin_testbed_driver", "skin_ident")
# tests that run in the background have Ctrl-C switched off, and so have their children
LISTENING = "import signal, sys, time; signal.signal(signal.SIGINT, signal.default_int_handler); "
SLOW = "print('begun', flush=True); time.sleep(60.0)"


def interrupted(program, cwd):
    """Status and last words of a program that is interrupted once it says that it has begun."""
    process = subprocess.Popen(
        [sys.executable, "-c", LISTENING + program], cwd=cwd, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert process.stdout.readline() == "begun\n", process.stderr.read()
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=30)[1]
    return process.returncode, said


@pytest.mark.parametrize("where", ["import time; " + SLOW, "def main():\n    import time; " + SLOW])
def test_ctrl_c_while_importing_and_while_running(tmp_path, where):
    (tmp_path / "slow.py").write_text(where + "\n")
    ended = interrupted("from skin_models.started import command; sys.path.insert(0, '.'); sys.exit(command('slow')())", tmp_path)
    assert ended == (130, "interrupted\n")


def test_ctrl_c_amid_an_import_that_swallows_it(tmp_path):
    (tmp_path / "slow.py").write_text(f"import time\ntry:\n    {SLOW}\nexcept BaseException:\n    pass\ndef main(): return 0\n")
    ended = interrupted("from skin_models.started import command; sys.path.insert(0, '.'); sys.exit(command('slow')())", tmp_path)
    assert ended == (130, "interrupted\n")


@pytest.mark.parametrize(
    ("name", "slow", "out"),
    [("effects_gallery", "skin_models.gallery.scene.pictures", "a.html"), ("skin_acuity", "skin_models.acuity.drawing.png", "a.png")],
)
def test_ctrl_c_while_drawing_leaves_nothing(tmp_path, name, slow, out):
    module, function = slow.rsplit(".", 1)
    program = (
        f"import {module} as slow, skin_models.executables as commands; sys.argv[1:] = ['{out}']\n"
        f"def wait(*_):\n    sys.stdout = sys.__stdout__; {SLOW}\n"
        f"sys.stdout = sys.stderr; slow.{function} = wait; sys.exit(commands.{name}())"
    )
    status, said = interrupted(program, tmp_path)
    assert status == 130 and said.endswith("interrupted\n") and "Traceback" not in said and not list(tmp_path.iterdir())


@pytest.mark.parametrize("package", PACKAGES)
def test_every_installed_command_starts_so(package):
    scripts = re.findall(r'"(\w+) = ([\w.]+):(\w+)"', (TOP / package / "setup.py").read_text())
    commands = importlib.import_module(f"{package}.executables")
    assert scripts and all((module, name) == (commands.__name__, script) for script, module, name in scripts)
    for script, _, _ in scripts:
        source = Path(importlib.util.find_spec(getattr(commands, script).module).origin).read_text()
        assert "\ndef main(" in source
