"""What the driver says on /diagnostics: how well it keeps its time, and every fault."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

from skin_models.words import counted
from skin_testbed_driver.motion import Activity
from skin_testbed_driver.sensing import DEAD, OK, SATURATED, STALE, STUCK, UNCALIBRATED, Sample
from skin_testbed_driver.statistics import LoopReport
from skin_testbed_driver.taring import Offsets
from skin_testbed_driver.testbed import Status

_NAMES = {SATURATED: "saturated", STALE: "stale", STUCK: "stuck", DEAD: "dead", UNCALIBRATED: "uncalibrated"}
_RATE_TOLERANCE = 0.01  # of the wanted rate


def diagnostics(
    name: str, loop: LoopReport, wanted: float, status: Status, sample: Sample | None, offsets: Offsets, others: str = ""
) -> DiagnosticArray:
    """Three statuses: the sampling loop, the motion, the sensors. `others` publish on the same topics. The caller sets the stamp."""
    return DiagnosticArray(status=[_loop(name, loop, wanted, others), _motion(name, status), _sensors(name, sample, offsets)])


def _loop(name: str, loop: LoopReport, wanted: float, others: str) -> DiagnosticStatus:
    slow = loop.rate < wanted * (1.0 - _RATE_TOLERANCE)
    level = DiagnosticStatus.WARN if slow or loop.skipped else DiagnosticStatus.OK
    message = f"{loop.rate:.2f} of {wanted:g} Hz, {counted(loop.skipped, 'sample')} skipped"
    if others:
        level, message = DiagnosticStatus.ERROR, f"{others} publishes the same topics"
    values = {
        "achieved_rate_hz": loop.rate, "wanted_rate_hz": wanted, "samples": loop.ticks, "overruns": loop.overruns, "skipped": loop.skipped,
        "jitter_p50_us": 1e6 * loop.jitter_p50, "jitter_p99_us": 1e6 * loop.jitter_p99, "jitter_max_us": 1e6 * loop.jitter_max,
    }  # fmt: skip
    return _status(f"{name}: sampling", level, message, values)


def _motion(name: str, status: Status) -> DiagnosticStatus:
    stopped = status.activity is Activity.STOPPED
    level = DiagnosticStatus.ERROR if stopped else DiagnosticStatus.OK
    message = f"stopped: {status.reason}" if stopped else status.activity.name.lower()
    return _status(f"{name}: motion", level, message, {"zeroed": status.zeroed, "tared": status.tared})


def _sensors(name: str, sample: Sample | None, offsets: Offsets) -> DiagnosticStatus:
    values = {"force_offset_n": offsets.force, **{f"taxel_{i}_offset_n": x for i, x in enumerate(offsets.taxels.tolist()) if x}}
    if sample is None:
        return _status(f"{name}: sensors", DiagnosticStatus.STALE, "no sample yet", values)
    faults = [word for word, bad in (("encoder", sample.depth != sample.depth), ("load cell", sample.force != sample.force)) if bad]
    faults += [f"taxel_{i} {_NAMES[int(s)]}" for i, s in enumerate(sample.taxel_status) if s != OK]
    level = DiagnosticStatus.ERROR if faults else DiagnosticStatus.OK
    return _status(f"{name}: sensors", level, "no trusted value from " + ", ".join(faults) if faults else "all sensors answer", values)


def _status(name: str, level: bytes, message: str, values: dict) -> DiagnosticStatus:
    pairs = [KeyValue(key=key, value=f"{value:.6g}" if isinstance(value, float) else str(value)) for key, value in values.items()]
    return DiagnosticStatus(name=name, level=level, message=message, hardware_id="skin_testbed", values=pairs)
