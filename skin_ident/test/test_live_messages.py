"""What the live fit says of itself in messages, without a node."""

from dataclasses import replace

import pytest
from making import recording
from test_live_fit import fed

pytest.importorskip("skin_testbed_msgs.msg")

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticStatus

from skin_ident.estimators.live import LiveFit
from skin_ident.ros.live_messages import diagnostics, estimates


def test_taxels_that_feel_more_than_is_applied_are_said_to():
    r = recording(n=2000, shares=(1.0, 0.3), sigma=0.02)
    fit = fed(replace(r, taxels=1.4 * r.taxels), 500)
    message, (status,) = estimates(fit, Time()), diagnostics(fit, Time(), "node").status
    verdicts = dict(zip(message.names, message.verdicts, strict=True))
    assert verdicts["k2"] == "negative" and verdicts["k1"] == "identifiable"
    assert status.level == DiagnosticStatus.WARN and "k2 is negative: the taxels feel more" in status.message


@pytest.mark.parametrize(("force", "channel"), [(True, "force"), (False, "taxel_0")])
def test_the_residual_is_called_by_the_channel_that_it_is_of(force, channel):
    r = recording(n=1000, shares=(1.0, 0.3), sigma=0.02)
    fit = LiveFit(30.0, 5.0, 0.0)
    for i in range(len(r)):
        stamp = round(r.t[i] * 1e9) + 10**12
        for role, values in (("encoder", r.depth[i : i + 1]), *[("force", r.force[i : i + 1])] * force, ("taxels", r.taxels[:, i])):
            fit.offer(role, stamp, values)
    fit.update()
    (status,) = diagnostics(fit, Time(), "node").status
    assert [v.key for v in status.values if "residual" in v.key] == [f"residual of {channel} (N rms)"]
