"""The worked example against the node: a finger of MuJoCo draws a circle, and the taxels see it go round."""

import os
import time

import numpy as np
import pytest

rclpy = pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from skin_testbed_msgs.msg import TaxelArray  # noqa: E402

from skin_models.layout import grid  # noqa: E402
from skin_models.ros.processes import Domain, Processes  # noqa: E402


@pytest.fixture
def processes(monkeypatch):
    with Domain() as domain:
        for name, value in domain.environment().items():
            monkeypatch.setenv(name, value)
        with Processes({**os.environ, **domain.environment()}) as running:
            yield running, domain


def test_without_mujoco_it_says_what_to_install(processes):
    running, _ = processes
    try:
        import mujoco  # noqa: F401
    except ImportError:
        node = running.start("skin_models", "mujoco_finger")
        assert node.wait(30.0) == 2 and "pip install mujoco" in node.output()


def test_taxels_follow_the_finger_round(processes):
    pytest.importorskip("mujoco")
    running, domain = processes
    parameters = {"layout": "grid", "columns": 9, "rows": 9, "pitch": 0.005}
    running.start("skin_models", "skin_node", parameters=parameters).wait_for_output("ready", 30.0)
    running.start("skin_models", "mujoco_finger").wait_for_output("ready", 30.0)
    context, heard = rclpy.Context(), []
    rclpy.init(context=context, domain_id=domain.id)
    node = rclpy.create_node("test", context=context)
    node.create_subscription(TaxelArray, "taxels", heard.append, 200)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(node)
    end = time.monotonic() + 12.0
    while time.monotonic() < end:
        executor.spin_once(timeout_sec=0.1)
    rclpy.shutdown(context=context)
    force = np.array([m.force for m in heard])
    pressed = force[force.sum(axis=1) > 1.0]
    centre = pressed @ grid(9, 9, 0.005).positions[:, :2] / pressed.sum(axis=1, keepdims=True)
    # The finger drags the contact along behind where it aims; friction makes the circle smaller than 12 mm.
    assert len(pressed) > 300 and 5e-3 < np.median(np.hypot(*centre.T)) < 13e-3
    assert np.ptp(np.unwrap(np.arctan2(centre[:, 1], centre[:, 0]))) > 2 * np.pi
