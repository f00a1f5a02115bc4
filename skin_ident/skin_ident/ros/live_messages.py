"""What the live fit knows, as messages and as a model."""

import math

from builtin_interfaces.msg import Time
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from skin_testbed_msgs.msg import ParameterEstimates

from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import FIXED
from skin_ident.estimators.live import LiveFit
from skin_ident.estimators.verdicts import negative, word_of
from skin_models.dispersion import Dispersion
from skin_models.model import Model

NAMES, UNITS = ("b1", "k1", "b2", "k2"), ("N*s/m", "N/m", "N*s/m", "N/m")


def estimates(fit: LiveFit, stamp: Time) -> ParameterEstimates:
    """The estimates now; NaN where nothing is known yet."""
    count = 4 if fit.memory is None else 4 + fit.memory.taxels
    values = [math.nan] * count if fit.live is None else fit.live.values.tolist()
    errors = [math.nan] * count if fit.live is None else fit.live.std.tolist()
    message = ParameterEstimates(model="dispersion", window=fit.window)
    message.header.stamp = stamp
    message.names = ["m", *_names(count)]
    message.values, message.standard_errors = [fit.mass, *values], [0.0, *errors]
    message.units = ["kg", *UNITS, *["1"] * (count - 4)]
    message.verdicts = [FIXED, *(_word(n, v, s) for n, v, s in zip(message.names[1:], values, errors, strict=True))]
    message.effective_samples = 0.0 if fit.live is None else float(fit.live.rows)
    return message


def _names(count: int) -> list[str]:
    """Names of so many parameters, without the mass."""
    return [*NAMES, *(f"share_{i}" for i in range(count - len(NAMES)))]


def _word(name: str, value: float, std: float) -> str:
    if std == 0.0 and name.startswith("share_") and value == 1.0:
        return FIXED  # shares are relative to the strongest taxel
    return word_of(value, std)


def std(fit: LiveFit) -> dict[str, float]:
    """Standard errors by parameter name."""
    return {} if fit.live is None else dict(zip(NAMES, fit.live.std.tolist(), strict=False))


def model(fit: LiveFit) -> Model:
    """The model as it is known now. Raises `FitError` where nothing is known yet, `ModelError` for values no skin can have."""
    if fit.live is None:
        raise FitError("there is no estimate yet: move the plunger in the skin first")
    b1, k1, b2, k2, *shares = fit.live.values.tolist()
    return Model(Dispersion(m=fit.mass, b1=b1, k1=k1, b2=b2, k2=k2), tuple(max(0.0, s) for s in shares), source="live estimate")


def diagnostics(fit: LiveFit, stamp: Time, name: str) -> DiagnosticArray:
    """Rate, losses and excitation, with the level a person must act on."""
    h, live = fit.health, fit.live
    level, message = _level(fit)
    first = "taxel_0" if fit.memory is not None and not fit.memory.force else "force"
    values = {
        "rate (Hz)": f"{h.rate:.4g}",
        "jitter (ms)": f"{round(1e3 * h.jitter, 6):.3g}",  # stamps are whole nanoseconds
        "samples used": h.used_ever,
        "samples without a partner": h.alone,
        "samples that are no numbers": h.invalid,
        "pauses": h.pauses,
        "taxels that send no numbers": h.silent,
        "speed in contact (mm/s rms)": f"{1e3 * live.speed:.3g}" if live else "",
        "depth in contact (mm rms)": f"{1e3 * live.depth:.3g}" if live else "",
        f"residual of {first} (N rms)": f"{live.residual[0]:.3g}" if live else "",
    }
    pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
    status = DiagnosticStatus(level=level, name=f"{name}: live identification", message=message, hardware_id="", values=pairs)
    array = DiagnosticArray(status=[status])
    array.header.stamp = stamp
    return array


def _level(fit: LiveFit) -> tuple[bytes, str]:
    if fit.memory is None:
        return DiagnosticStatus.STALE, "no encoder and force (or taxels) with common stamps yet"
    if fit.health.used == 0:
        why = f": nothing came on {' and '.join(fit.health.unheard)}" if fit.health.unheard else ""
        return DiagnosticStatus.STALE, f"no complete samples since the last look{why}"
    if fit.live is None:
        return DiagnosticStatus.OK, "not enough motion in the skin yet"
    if fit.health.alone + fit.health.invalid > 0.05 * max(1, fit.health.used):
        return DiagnosticStatus.WARN, "samples are lost or no numbers"
    if fit.health.silent:
        return DiagnosticStatus.WARN, f"estimating; {fit.health.silent} of the taxels send no numbers and are taken for silent"
    against = negative({n: word_of(v, s) for n, v, s in zip(_names(fit.live.values.size), fit.live.values, fit.live.std, strict=True)})
    if against:
        return DiagnosticStatus.WARN, f"estimating; {'; '.join(against)}"
    return DiagnosticStatus.OK, "estimating"
