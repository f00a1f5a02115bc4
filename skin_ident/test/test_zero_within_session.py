"""A session of the installed driver, profile server and recorder, in which the sensors are tared anew between two motions."""

import numpy as np
import pytest

pytest.importorskip("rclpy")
pytest.importorskip("skin_testbed_msgs")

from skin_ident.recordings.load import load
from skin_ident.ros import testbed as rig

SINE = "{type: sine, offset_mm: 0.4, amplitude_mm: 0.3, frequency_hz: 0.5, periods: %d}"
AIR = "{type: free_air, clearance_mm: 1.0, duration_s: 0.5}"


@pytest.mark.slow
def test_the_session_ends_at_the_tare(tmp_path):
    with rig.Testbed(None, seed=1, time_scale=5.0) as running:
        running.execute(rig.TARE)
        tare = "{type: tare, duration_s: 1}"
        battery = f"{{type: battery, profiles: [{SINE % 2}, {AIR}, {tare}, {SINE % 6}]}}"
        r = load(running.session(tmp_path / "session", battery))[0]
    assert [w.partition(" at ")[0] for w in r.warnings if "tared" in w] == ["the loads were tared anew"]
    pressed = np.flatnonzero(r.depth > 0.0)
    assert 15.0 < r.dt * np.ptp(pressed) < 19.0 and pressed[0] > 0  # six periods of 2 s with their leads, and not the two before
