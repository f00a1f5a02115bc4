"""A rig of one's own, as the page says: the file that it shows is what is tried here."""

import re
import textwrap
from pathlib import Path

import numpy as np
import pytest

from skin_models.layout import row_from_origin
from skin_testbed_driver.calibration import thesis_calibration
from skin_testbed_driver.rig import Rig, RigError
from skin_testbed_driver.rigs.own import own_rig
from skin_testbed_driver.safety import Limits
from skin_testbed_driver.testbed import Testbed

PAGE = Path(__file__).parents[1] / "README.md"


@pytest.fixture
def my_rig(tmp_path) -> str:
    """The file that the page shows."""
    section = PAGE.read_text().partition("## A new rig")[2]
    code = next(block for block in re.findall(r"(?:^ {4}.*\n|^\n)+", section, re.MULTILINE) if "class MyRig" in block)
    (tmp_path / "my_rig.py").write_text(textwrap.dedent(code))
    return str(tmp_path / "my_rig.py")


def test_the_rig_of_the_page_is_driven_like_any_other(graph, my_rig):
    pytest.importorskip("skin_testbed_msgs")
    from geometry_msgs.msg import WrenchStamped
    from skin_testbed_msgs.msg import DriverState, TaxelArray

    graph.driver(rig=my_rig, rig_options="{port: here}", time_scale=1.0, taxels=2)
    force, taxels = graph.hear(WrenchStamped, "force"), graph.hear(TaxelArray, "taxels")
    graph.command((2.0, 1e-3, 0.0))
    graph.wait(lambda: graph.state() == DriverState.MOVING, "motion")
    graph.wait(lambda: graph.state() == DriverState.READY, "its end")
    count = len(force)
    graph.wait(lambda: len(force) > count + 20 and taxels, "samples")
    assert -force[-1].wrench.force.z == pytest.approx(5.0, abs=0.1)
    assert list(taxels[-1].force) == pytest.approx([0.1 * 9.40825, 0.1 * 13.75], abs=0.05)


def test_the_page_names_every_method_that_a_rig_can_have(my_rig):
    shown = Path(my_rig).read_text()
    assert all(f"def {name}(" in shown for name in (*Rig.__abstractmethods__, "halt", "close"))


@pytest.mark.parametrize(
    ("code", "options", "words"),
    [
        ("import nothing_like_this", "", "No module named"),
        ("x = 1", "", "needs one class"),
        ("from skin_testbed_driver.rig import Rig\nclass A(Rig):\n    def read(self): pass", "", "A lacks command, open"),
        (None, "{speed: 3}", "rig_options"),
        (None, "[1]", "mapping"),
        (None, "{", "not YAML"),
    ],
)
def test_a_file_that_is_no_rig_is_refused_in_a_sentence(tmp_path, my_rig, code, options, words):
    if code is not None:
        Path(my_rig).write_text(code + "\n")
    with pytest.raises(RigError, match=words):
        own_rig(my_rig, row_from_origin(1), options)


def test_a_rig_that_contradicts_its_layout_is_refused(my_rig):
    rig = own_rig(my_rig, row_from_origin(3), "{port: here}")
    testbed = Testbed(rig, thesis_calibration(3), Limits())
    rig.layout = row_from_origin(2)
    rig.read = lambda read=rig.read: read()._replace(taxel_voltage=np.zeros(3))
    with pytest.raises(RigError, match="reads 3 taxels, its layout has 2"):
        testbed.tick(0.0)


@pytest.mark.parametrize("values", [[0.0, 0.0], np.zeros(2, np.float32), np.zeros(2, int), np.zeros((1, 2))])
def test_readings_that_are_no_arrays_of_numbers_are_refused_in_a_sentence(my_rig, values):
    rig = own_rig(my_rig, row_from_origin(2), "{port: here}")
    testbed = Testbed(rig, thesis_calibration(2), Limits())
    rig.read = lambda read=rig.read: read()._replace(taxel_voltage=values)
    with pytest.raises(RigError, match=r"taxel_voltage must be an array of float64, one per taxel: np.array\(values, float\)"):
        testbed.tick(0.0)


def test_errors_of_the_hardwares_own_become_a_sentence(my_rig):
    text = Path(my_rig).read_text()
    Path(my_rig).write_text(text.replace("self._position = 0.073", 'raise OSError("no such port")'))
    with pytest.raises(RigError, match="cannot be opened: OSError: no such port"):
        Testbed(own_rig(my_rig, row_from_origin(2), "{port: here}"), thesis_calibration(2), Limits())
    Path(my_rig).write_text(text.replace("self.layout, self._port", "self.layout, self._port = layout, open(port)\n        self._x"))
    with pytest.raises(RigError, match="FileNotFoundError"):
        own_rig(my_rig, row_from_origin(2), "{port: /nowhere/at/all}")


def test_a_file_that_is_not_there_is_said_in_words(tmp_path):
    with pytest.raises(RigError, match=r"cannot load the rig .*norig\.py: no such file$"):
        own_rig(str(tmp_path / "norig.py"), row_from_origin(2), "")


FAILING = """
from skin_testbed_driver.rig import Reading, Rig

class Failing(Rig):
    travel = (0.0, 0.15)

    def __init__(self, layout):
        self.layout = layout

    def open(self, sample_rate):
        pass

    def read(self):
        raise OSError("cable pulled")

    def command(self, position, velocity):
        pass

    def halt(self):
        raise OSError("no brake")
"""


def test_a_rig_that_cannot_even_halt_ends_the_node_all_the_same(graph, tmp_path):
    (tmp_path / "failing.py").write_text(FAILING)
    driver = graph.processes.start("skin_testbed_driver", "driver_node", parameters={"rig": str(tmp_path / "failing.py")})
    assert driver.wait(20.0) == 2
    assert "sampling failed (cable pulled): the axis could not be halted (no brake), see to it by hand" in driver.output()
