"""What the steps of encoder and converters leave open, which a gain must exceed to be that of a cause."""

from collections.abc import Iterable

import numpy as np

from skin_ident.criticism.baseline.residual import stiffness
from skin_ident.criticism.gates.gate import MUCH, Gain
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.telemetry.quantization import step_of
from skin_models.effect import Effect, Place
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, parameters_of

OPEN = 0.5  # of the mean square that an encoder's steps leave open, which a gain must exceed
UNEVEN = 0.1  # of a converter's step, which a gain must exceed: motion carries readings across steps, rest does not
TREMBLING = 1e-6  # m, of a good stage at rest
OF_SPEED = ("rate_dependence", "mount_compliance")


def resolved(gain: Gain, cause: str, model: Model, train: list[Session], encoder_step: float) -> bool:
    """Whether the gain is more than what steps leave open. Those of the encoder leave a force of k q / sqrt(12), the same one wherever the
    plunger comes back to, so that held-out sessions repeat it; those of the converter are uneven where noise does not carry the readings
    across them. And damping feels speeds that nobody reads: what depends on speed, or smooths the depth, must exceed that, too, unless the
    likelihood gains much by it."""
    k, skin = stiffness(model, gain.channel), model.dispersion
    felt = (skin.b1 + skin.b2) * _unread_speed(train, encoder_step) if cause in OF_SPEED and gain.relative < MUCH else 0.0
    return gain.squares > OPEN * (k * encoder_step) ** 2 / 12.0 + felt**2 + (UNEVEN * _converter_step(train, gain.channel)) ** 2


def _unread_speed(sessions: list[Session], encoder_step: float) -> float:
    """What steps of the depth make of its speed within the band, m/s: a stage at rest trembles between them, evenly up to the band's edge;
    one that moves is rounded at every sample, evenly up to half the sampling rate."""
    band = sessions[0].band
    at_rest = min(encoder_step, TREMBLING)
    moving = encoder_step * np.sqrt(2.0 * band.edge * band.dt)
    return 2.0 * np.pi * band.edge / np.sqrt(3.0) * max(at_rest, moving) / np.sqrt(12.0)


def readable(effects: Iterable[Effect], encoder_step: float) -> bool:
    """Whether lengths by which the tip is said to be off are such as the encoder could tell: half of its step, or more."""
    off = [e for e in effects if e.place is Place.DEPTH]
    lengths = [abs(p.value) for e in off for p in parameters_of(e) if p.role == AMPLITUDE and p.unit == "m"]
    return not lengths or max(lengths) > 0.5 * encoder_step


def _converter_step(train: list[Session], channel: str) -> float:
    """The converter's step in a channel, N; zero where none is seen."""
    row = train[0].channels.index(channel)
    return max(step_of(s.raw[row]) or 0.0 for s in train)
