"""How large a gain encoder and converters can account for by their steps and noise; the gain of a cause must be larger.

What they "leave open" of a channel is the mean square error, N^2, that steps and noise may cause there.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from skin_ident.criticism.baseline.residual import damping, residual, stiffness
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.feigned import explains_more, is_feigned
from skin_ident.criticism.gates.gate import MUCH_FALL
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.cutoff import dilution
from skin_ident.criticism.sessions.read_again import UNZEROED
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.vocabulary import Key
from skin_ident.estimators.scale import normal_scale
from skin_models.effect import Effect, Place
from skin_models.effects.hysteresis import BoucWenHysteresis, SensorHysteresis, SkinHysteresis
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, parameters_of

# Share of what is left open in all, which a fall while the stage moves must exceed, too: each motion comes from rest and goes to it.
PASSING = 0.5
OPEN = 2.0  # times the mean square error that steps cause on average: at few depths chance may make it so much
# The same factor where sessions are held at few depths, and for the residual of a final model. At a few depths each rounding may be off by
# half a step, which is three times the mean square, and the model that was fitted at few other depths may be off as far the other way.
AT_FEW_DEPTHS = 6.0
FEW, APART = 4.0, 4.0  # number of depths below which the factor is AT_FEW_DEPTHS; encoder steps by which two depths differ
SURELY = 12.0  # times what may be left open, above which a gain is not tested for mimicry: chance accounts for a tenth of it on average
# Number of depths below which the rounding at each may be anything, and reading anew does not tell how much it mimics. Pyramids of holds
# have 8 where an encoder reads in steps of 20 µm, and full protocols 36 in steps of 5 µm.
MANY = 15.0
UNEVEN = 0.1  # of a converter's step, RMS, which a gain must exceed: motion carries readings across steps, rest does not
INTEGRAL = 0.3  # of a step, RMS: a converter's integral nonlinearity of 0.4 steps up and down
UNFLICKERING = 0.5  # of a step: how far a converter with hysteresis of its own may lag behind
ROUNDED = 0.5  # of a step: how far a tare may leave a zero off
RESOLVED = float(np.hypot(INTEGRAL, ROUNDED))  # of a step, RMS: the residual that these two may leave together
OF_READING = ("nonlinear_stiffness", "saturation", "dead_zone")  # causes that bend a reading as the nonlinearity of a converter does
TREMBLING = 1e-6  # m, tremble of a good stage at rest
EVEN_S = 0.5  # s over which the speed is averaged: a beat makes spikes of it
MOVING = 2.0  # times the greatest speed of such a tremble, above which the stage moves
TRAVEL_S, TRAVELLED = 1.0, 1.5  # a moving stage changes its depth by more than TRAVELLED encoder steps within TRAVEL_S seconds
# Causes that show where the stage moves fast; there steps mimic a speed that is not there.
OF_SPEED = ("rate_dependence", "mount_compliance")
CLEARLY = 3.0  # standard deviations of its noise by which the rate of the driving force must differ from zero
DRIVEN = 0.3  # least share of the fall that must lie where the driving force changes
# Causes that smooth the depth, and with it its steps and noise.
SMOOTHING = ("rate_dependence", "mount_compliance", "stress_relaxation", "hysteresis", "backlash", "lag", "time_shift", "quantization")
DILUTED = 0.15  # fall of the mean square, plain or whitened, up to which noise of the driving signal may account for it

Part = Callable[[Session], np.ndarray]  # a mask (n,) of the samples that count


def of_the_converter(claim: Claim) -> bool:
    """Whether a good converter may do it: bend a reading by its integral nonlinearity, or make a loop of it by the hysteresis that keeps a
    reading from flickering between two levels."""
    step = converter_step(claim.train, claim.channel)
    loops = [e for e in claim.after.having(claim.key) if isinstance(e, SensorHysteresis)]
    if loops:
        return max(loops, key=lambda e: abs(e.relative)).threshold <= UNFLICKERING * step
    return claim.cause in OF_READING and claim.gain.squares <= (INTEGRAL * step) ** 2


def resolved(claim: Claim, noise: Whitener | None, encoder_step: float, strict: bool = False) -> bool:
    """Whether the gain exceeds what encoder and converters leave open, over the whole record or while the stage moves (a stage that
    trembles at rest does not while it moves). This bound covers the most that an encoder can do, which is far more than it does to most
    causes. So where the outcome hangs on it, both models are tested for what the encoder mimics of this very cause, under the `noise` of
    the channels; `noise` is None where `after` does not hold all that gains, as with courses."""
    train, fits = claim.train, (claim.before, claim.after, claim.train)
    still, moving = _left_open(claim, encoder_step, strict)
    moves, step = partial(_moves, encoder_step), without_noise(encoder_step, train)
    asked = noise is not None and not claim.driven and encoder_step > 0.0
    if claim.gain.squares > still or (encoder_step > 0.0 and _fall_in(moves, claim) > max(moving, PASSING * still)):
        return not (asked and claim.gain.squares < SURELY * still and is_feigned(*fits, noise, step))
    if not asked or claim.gain.squares <= _uneven(claim):
        return False
    return held_depths(train, step) > MANY and explains_more(*fits, noise, step)


def _noise_at_most(claim: Claim) -> float:
    """The most that white noise of the encoder explains, N^2. Most of it averages out within the band. A cause that smooths the depth, or
    takes over some of the damping, keeps the rest out of the simulated forces."""
    train, k, drag = claim.train, stiffness(claim.before, claim.channel), _drag(claim)
    if claim.cause not in SMOOTHING:
        return OPEN * _trembling(train, k, 0.0) ** 2
    # Such a cause also undoes the bias that noise of the depth gives to the fitted damping.
    return OPEN * _trembling(train, k, drag) ** 2 + (drag * dilution(train) * _speed_rms(train)) ** 2


def _left_open(claim: Claim, encoder_step: float, strict: bool) -> tuple[float, float]:
    """The most that encoder and converters leave open of the claim's channel, N^2: over the whole record, and while the stage moves.

    - Encoder steps cause a force error that is the same whenever the plunger comes back to a depth, so that held-out sessions repeat it.
    - They also leave the zero of depth off, which looks like a bent reading where the stiffness is free.
    - Converter steps are uneven where noise does not carry the readings across them.
    - Damping acts on speeds that the encoder does not resolve. A cause in `OF_SPEED` must also exceed the beat of steps against samples in
      the worst session. It must exceed the unresolved speeds as well, unless the likelihood gains much by it and the test is not `strict`.
    - A depth error shows in every channel. Where one channel alone gains, and another has a smaller residual than the error would leave
      there, the error is no larger than that. This does not hold at few depths, where the other channel's own stiffness may have absorbed
      the error.
    """
    before, train = claim.before, claim.train
    k, b, drag = stiffness(before, claim.channel), before.dispersion.b1 + before.dispersion.b2, _drag(claim)
    moves, step = partial(_moves, encoder_step), without_noise(encoder_step, train)
    chance = AT_FEW_DEPTHS if held_depths(train, step) < FEW else OPEN
    unzeroed = UNZEROED * step if claim.cause in OF_READING else 0.0
    alone = chance == OPEN and len(claim.gain.carried) == 1 and not claim.driven
    left = [(s, residual(before, s)) for s in train] if alone else []

    def unread(part: Part | None) -> float:
        """Mean square error of the depth, m^2."""
        return min(chance * unread_depth(train, step, part) ** 2 + unzeroed**2, _shared_depth(before, claim.channel, left, part) ** 2)

    uneven, by_noise = _uneven(claim), _noise_at_most(claim)
    still, moving = (k**2 * unread(part) + uneven + by_noise for part in (None, moves))
    if claim.cause in OF_SPEED:
        beats = OPEN * max((drag * _beat([s], step)) ** 2 for s in train)
        still, moving = still + beats, moving + beats
        if strict or claim.gain.relative < MUCH_FALL:
            resting, passing = ((b * speed) ** 2 for speed in _unread_speeds(train, encoder_step))
            still, moving = still + max(resting, passing), moving + passing
    return still, moving


def _uneven(claim: Claim) -> float:
    """Mean square error that uneven steps of the channel's converter may cause, N^2."""
    return (UNEVEN * converter_step(claim.train, claim.channel)) ** 2


def _drag(claim: Claim) -> float:
    """Damping of the channel, N s/m. For a cause that smooths the depth, the larger value of both models: it may exchange damping with the
    skin."""
    models = (claim.before, claim.after) if claim.cause in SMOOTHING else (claim.before,)
    return max(damping(m, claim.channel) for m in models)


def of_the_drive(claim: Claim) -> bool:
    """Whether noise of the driving force may account for the gain. A cause that smooths or delays that force keeps some of its noise out of
    the simulated taxels, and out of nothing else (W. A. Fuller, Measurement Error Models, 1987, ch. 1). It may where a channel gains
    little, and where a cause of speed gains mostly while the force rests."""
    gain = claim.gain
    if not claim.driven or claim.cause not in SMOOTHING:
        return False
    if gain.relative < DILUTED and gain.squares < DILUTED * gain.before**2:
        return True
    if claim.cause not in OF_SPEED:
        return False
    falls = _falls(claim)
    moving = sum(float(np.sum(fall * _driven(s))) for fall, s in zip(falls, claim.train, strict=True))
    return moving < DRIVEN * sum(float(np.sum(fall)) for fall in falls)


def _driven(s: Session) -> np.ndarray:
    """Mask (n,) in the common band: where the driving force changes by more than its noise does."""
    speed = _speed(s)
    even = _even(speed, s)
    return np.abs(even) > CLEARLY * normal_scale(speed - even)


def unread_depth(sessions: list[Session], encoder_step: float, part: Part | None = None) -> float:
    """Depth error, m RMS, that steps q cause in the common band: q / sqrt(12) where the stage rests. Where it passes n steps in half a
    period of the band's edge, their errors average out and 1 / n of the mean square remains. `part` says which samples count."""

    def squares(s: Session) -> np.ndarray:
        path = np.abs(_speed(s)) / (2.0 * s.band.edge)
        return (encoder_step**2 / 12.0 * np.minimum(1.0, encoder_step / np.maximum(path, 1e-12)))[part(s) if part else slice(None)]

    every = np.concatenate([squares(s) for s in sessions])
    return float(np.sqrt(every.mean())) if every.size else 0.0


def _shared_depth(model: Model, channel: str, left: list[tuple[Session, np.ndarray]], part: Part | None = None) -> float:
    """The largest depth error, m RMS, that the residuals `left` (C, n) of the other channels allow: the least ratio of RMS residual to
    stiffness; inf where there is no other channel."""
    power, count = 0.0, 0.0
    for s, e in left:
        counts = s.weight * (part(s) if part else 1.0)
        power, count = power + np.sum(counts * e**2, axis=1), count + np.sum(counts, axis=1)
    rms, channels = np.sqrt(power / np.maximum(count, 1.0)), left[0][0].channels if left else ()
    return min((float(rms[c]) / max(stiffness(model, other), 1e-9) for c, other in enumerate(channels) if other != channel), default=np.inf)


def held_depths(sessions: list[Session], encoder_step: float) -> float:
    """Effective number of contact depths at which the sessions spend their time: 1 / (sum of the squared shares of time). inf without
    steps."""
    depth = np.concatenate([s.motion.x[s.motion.x > 0.0] for s in sessions if s.drive is None] or [np.zeros(0)])
    if not (encoder_step and depth.size):
        return np.inf
    _, counts = np.unique(np.round(depth / (APART * encoder_step)), return_counts=True)
    return float(1.0 / np.sum((counts / counts.sum()) ** 2))


def unread_force(model: Model, channel: str, sessions: list[Session], encoder_step: float) -> float:
    """Error of a channel, N RMS, that unread parts of the driving signal may cause: stiffness times the depth error of steps and noise, and
    damping times their speed error. Of a driving force it is the noise of that force, scaled by the channel's stiffness over the load
    cell's."""
    step, (k, b) = without_noise(encoder_step, sessions), (of(model, channel) for of in (stiffness, damping))
    steps = np.hypot(k * unread_depth(sessions, step), b * _beat(sessions, step))
    driving = k / max(stiffness(model, "force"), 1e-9) * max(s.drive_noise for s in sessions)
    return float(np.linalg.norm([steps, _trembling(sessions, k, b), driving]))


def left_by_steps(model: Model, channel: str, sessions: list[Session], encoder_step: float) -> float:
    """What steps of converter and encoder may leave open in a channel of sessions that return to few depths, N."""
    own = max(s.steps[s.channels.index(channel)] for s in sessions)
    return float(np.hypot(RESOLVED * own, np.sqrt(AT_FEW_DEPTHS) * unread_force(model, channel, sessions, encoder_step)))


def without_noise(encoder_step: float, sessions: list[Session]) -> float:
    """The encoder's steps alone, m, where `encoder_step` is the step whose rounding is as loud as its steps and white noise together."""
    return float(np.sqrt(max(encoder_step**2 - 12.0 * max(s.depth_noise for s in sessions) ** 2, 0.0)))


def _trembling(sessions: list[Session], k: float, b: float) -> float:
    """Error of a force k x + b v in the common band, N RMS, that white noise of the encoder causes at the recorded sampling rate: the
    samples of a search are thinned out, and each of them holds less of it."""

    def force(s: Session) -> float:
        return s.depth_noise * replace(s.band, dt=s.period).passes * float(np.hypot(k, b * _per_length(s.band)))

    return max(force(s) for s in sessions)


def _speed_rms(sessions: list[Session]) -> float:
    """RMS speed of the plunger in contact, m/s."""
    squares = np.concatenate([s.motion.v[s.motion.x > 0.0] ** 2 for s in sessions])
    return float(np.sqrt(squares.mean())) if squares.size else 0.0


def _per_length(band: Band) -> float:
    """RMS speed over RMS depth, 1/s, of a signal with a flat spectrum up to the band's edge w: w / sqrt(3)."""
    return 2.0 * np.pi * band.edge / np.sqrt(3.0)


def _beat(sessions: list[Session], encoder_step: float) -> float:
    """Speed error, m/s RMS, that steps q cause in the common band where the stage passes nearly a whole number n of them per sample.
    Rounding is then no noise but a sawtooth of f = |v / q - n / dt| Hz, each of whose harmonics adds 2 (f q)^2 to the mean squared
    speed."""
    squares = [np.zeros(1)]
    for s in sessions if encoder_step > 0.0 else ():
        passed = _even(np.abs(_speed(s)), s) / encoder_step  # steps a second
        whole = np.round(passed * s.period) / s.period
        f = np.where(whole > 0.0, np.abs(passed - whole), np.inf)
        f = np.where(f < s.band.edge, np.maximum(f, 1e-9), np.inf)
        harmonics = np.floor(s.band.edge / f)
        squares.append(2.0 * harmonics * (np.where(harmonics > 0.0, f, 0.0) * encoder_step) ** 2)
    return float(np.sqrt(np.concatenate(squares).mean()))


def _unread_speeds(sessions: list[Session], encoder_step: float) -> tuple[float, float]:
    """Speed errors within the band that steps of the depth cause, m/s RMS, at rest and in motion. A stage at rest trembles between steps,
    with a flat spectrum up to the band's edge. One that moves is rounded anew at every sample, with a flat spectrum up to half the sampling
    rate."""
    band, period = sessions[0].band, sessions[0].period
    per_length = _per_length(band) / np.sqrt(12.0)
    return per_length * min(encoder_step, TREMBLING), per_length * encoder_step * float(np.sqrt(2.0 * band.edge * period))


def _fall_in(part: Part, claim: Claim) -> float:
    """Fall of the mean square error in the claim's channel over the samples of a part, N^2."""
    fall, count = 0.0, 0.0
    for s, each in zip(claim.train, _falls(claim), strict=True):
        counts = part(s)
        fall += float(np.sum(each * counts))
        count += float(np.sum(s.weight[s.channels.index(claim.channel)] * counts))
    return fall / max(count, 1.0)


def _falls(claim: Claim) -> list[np.ndarray]:
    """Fall of the squared residual in the claim's channel, N^2, at every trusted sample, (n,) for each session."""
    rows = [s.channels.index(claim.channel) for s in claim.train]
    return [
        s.weight[row] * (residual(claim.before, s)[row] ** 2 - residual(claim.after, settled(claim.after, s))[row] ** 2)
        for row, s in zip(rows, claim.train, strict=True)
    ]


def _moves(encoder_step: float, s: Session) -> np.ndarray:
    """Mask (n,) in the common band: where the stage moves faster than it could tremble, and farther than between two readings. At rest on
    the edge of a step the encoder reports motion that is not there."""
    faster = np.abs(_speed(s)) > MOVING * 2.0 * np.pi * s.band.edge * TREMBLING
    depth, around = np.interp(s.t, s.motion.t, s.motion.x), round(TRAVEL_S / s.band.spacing) | 1
    return faster & (maximum_filter1d(depth, around) - minimum_filter1d(depth, around) > TRAVELLED * encoder_step)


def _even(speed: np.ndarray, s: Session) -> np.ndarray:
    """The speed averaged over `EVEN_S`."""
    return uniform_filter1d(speed, max(round(EVEN_S / s.band.spacing), 1))


def _speed(s: Session) -> np.ndarray:
    return np.interp(s.t, s.motion.t, s.motion.v)


def unreadable(key: Key, model: Model, encoder_step: float) -> float:
    """The largest length, m, by which a cause puts the tip off, or a loop is wide, where the encoder could not tell it; else 0. It
    cannot tell one of a step or less: at a few depths, reached from both sides, its rounding alone looks like as much."""
    effects = model.having(key)
    off = [e for e in effects if e.place is Place.DEPTH]
    lengths = [abs(p.value) for e in off for p in parameters_of(e) if p.role == AMPLITUDE and p.unit == "m"]
    largest = max(lengths, default=_width_of_loop(effects, stiffness(model, "force"), encoder_step))
    return largest if largest <= encoder_step else 0.0


def _width_of_loop(effects: list[Effect], k: float, encoder_step: float) -> float:
    """Half the width of the skin's loops, m, where they yield within a step of the encoder; else 0. Loops as narrow as that are what an
    encoder makes that lags by part of a step, to keep its reading from flickering between two levels."""
    loops = [e for e in effects if isinstance(e, SkinHysteresis | BoucWenHysteresis)]
    if not loops or max(e.threshold for e in loops) > encoder_step:
        return 0.0
    return sum((e.k_sensed + e.k_dispersed) * e.threshold for e in loops) / k


def converter_step(train: list[Session], channel: str) -> float:
    """Step of a channel's converter, N; 0 where none is seen."""
    row = train[0].channels.index(channel)
    return max(s.steps[row] for s in train)
