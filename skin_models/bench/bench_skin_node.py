"""What the skin node costs: share of one core for 1,000 taxels at 1 kHz under four moving contacts, what it achieves and what arrives.

Once with the plain material, whose forces pass a filter, and once with relaxation and hysteresis in the skin, where every contact's
depth is looked for. On a machine without a core to spare the achieved rate falls short, and the share with it: it is also given per
1,000 samples.

The rival is the same node with every array handed to rclpy as a list of floats, as most Python nodes do: one message of the two is filled
and published alone, in this process, both ways.

It drives the installed node from outside, over DDS; that is why this bench, unlike the others here, imports ROS.
"""

import math
import os
import tempfile
import time
from array import array
from pathlib import Path

import numpy as np
import rclpy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import Point
from skin_testbed_msgs.msg import Contact, ContactArray, TaxelArray

from skin_models.effects.hysteresis import SkinHysteresis
from skin_models.effects.stress_relaxation import StressRelaxation
from skin_models.materials import material
from skin_models.model_file import save_model
from skin_models.ros.processes import Domain, Processes

TAXELS, RATE, SECONDS = 1000, 1000.0, 5.0
EXTENDED = material("silicone_4mm").model.extended(StressRelaxation.typical("skin")).extended(SkinHysteresis.typical("skin"))


def spent(pid: int) -> float:
    """Processor time of a process so far, s."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def press(publisher, i: int) -> None:
    """Four contacts on a circle."""
    angles = [2 * math.pi * i / 200 + k for k in range(4)]
    at = [Point(x=0.02 * math.cos(a), y=0.02 * math.sin(a)) for a in angles]
    publisher.publish(ContactArray(contacts=[Contact(name=str(k), position=p, force=3.0, depth=math.nan) for k, p in enumerate(at)]))


def node_cost(listen: bool, model: str = "silicone_4mm") -> tuple[float, float, float]:
    """Share of a core, samples per second that the node says it made, messages per second that arrive here (if this process listens)."""
    with Domain() as domain:
        os.environ.update(domain.environment())
        with Processes(dict(os.environ)) as processes:
            parameters = {"layout": "grid", "columns": 40, "rows": TAXELS // 40, "pitch": 0.005, "rate": RATE, "model": model}
            node = processes.start("skin_models", "skin_node", parameters=parameters)
            node.wait_for_output("ready", 60.0)
            return _watched(node.pid, domain.id, listen)


def _watched(pid: int, domain_id: int, listen: bool) -> tuple[float, float, float]:
    context, heard, reports = rclpy.Context(), [], []
    rclpy.init(context=context, domain_id=domain_id)
    me = rclpy.create_node("bench", context=context)
    if listen:
        me.create_subscription(TaxelArray, "taxels", lambda m: heard.append(None), 1000)
    me.create_subscription(DiagnosticArray, "/diagnostics", lambda m: reports.extend(m.status), 10)
    executor = rclpy.executors.SingleThreadedExecutor(context=context)
    executor.add_node(me)
    contacts, start, i = me.create_publisher(ContactArray, "contacts", 10), None, 0
    began = time.monotonic()
    while time.monotonic() - began < SECONDS + 1.0:
        press(contacts, i)
        i, until = i + 1, began + 0.01 * (i + 1)
        while (left := until - time.monotonic()) > 0:
            executor.spin_once(timeout_sec=left)
        if start is None and time.monotonic() - began > 1.0:
            start = spent(pid), len(heard), time.monotonic()
    took = time.monotonic() - start[2]
    share, arrived = (spent(pid) - start[0]) / took, (len(heard) - start[1]) / took
    rclpy.shutdown(context=context)
    return share, _achieved(reports[1:]), arrived


def _achieved(reports: list[DiagnosticStatus]) -> float:
    """Mean of the rates that the node reported, Hz."""
    rates = [float(v.value) for status in reports for v in status.values if v.key == "achieved_rate_hz"]
    return float(np.mean(rates)) if rates else math.nan


def publish_cost(as_list: bool) -> float:
    """Microseconds to fill and publish one message of `TAXELS` taxels."""
    context = rclpy.Context()
    rclpy.init(context=context)
    node = rclpy.create_node("bench", context=context)
    publisher, values, message = node.create_publisher(TaxelArray, "bench", 10), np.random.rand(TAXELS), TaxelArray()
    start = time.process_time()
    for _ in range(1000):
        message.force = values.tolist() if as_list else array("d", values.tobytes())
        message.status = [0] * TAXELS if as_list else array("B", bytes(TAXELS))
        publisher.publish(message)
    took = (time.process_time() - start) * 1e3
    rclpy.shutdown(context=context)
    return took


def main() -> None:
    """Print the table."""
    print(f"{TAXELS} taxels at {RATE:g} Hz, taxels and taxels_truth, four moving contacts")
    with tempfile.TemporaryDirectory() as folder:
        extended = str(Path(folder) / "extended.yaml")
        save_model(EXTENDED, extended)
        for name, listen, model in (
            ("nobody listens", False, "silicone_4mm"),
            ("one subscriber", True, "silicone_4mm"),
            ("two effects in the skin", True, extended),
        ):
            share, achieved, arrived = node_cost(listen, model)
            came = f", {arrived:.0f} messages/s arrive" if listen else ""
            cost = f"{100 * share:5.1f} % of one core at {achieved:4.0f} Hz, {1e5 * share / achieved:5.1f} % at 1 kHz"
            print(f"  {name:24s}{cost}{came}")
    fast, slow = publish_cost(as_list=False), publish_cost(as_list=True)
    print(f"  one message, arrays     {fast:5.0f} us")
    print(f"  one message, lists      {slow:5.0f} us ({slow / fast:.1f} times as much)")


if __name__ == "__main__":
    main()
