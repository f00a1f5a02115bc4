"""What the steps of encoder and converters leave open, which a gain must exceed to be that of a cause."""

from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial

import numpy as np
from scipy.ndimage import maximum_filter1d, minimum_filter1d, uniform_filter1d

from skin_ident.criticism.baseline.residual import damping, residual, stiffness
from skin_ident.criticism.baseline.settling import settled
from skin_ident.criticism.gates.claim import Claim
from skin_ident.criticism.gates.feigned import explains_more, is_feigned
from skin_ident.criticism.gates.gate import MUCH
from skin_ident.criticism.noise.whitening import Whitener
from skin_ident.criticism.sessions.band import Band
from skin_ident.criticism.sessions.cutoff import dilution
from skin_ident.criticism.sessions.read_again import UNZEROED
from skin_ident.criticism.sessions.session import Session
from skin_ident.estimators.scale import normal_scale
from skin_models.effect import Effect, Place
from skin_models.effects.hysteresis import SensorHysteresis
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, parameters_of

PASSING = 0.5  # of what steps leave open at rest, which a fall where the stage moves must exceed: it comes from rest and goes to it
OPEN = 2.0  # times the mean square that steps leave open on average: at few depths chance makes it so much
# The same of what is left when a cause has been taken, or none: at a few depths each may be half a step off, which is three times, and the
# model that was fitted to few others as far the other way.
AT_FEW_DEPTHS = 6.0
FEW, APART = 4.0, 4.0  # depths at which a gain is asked so much, and steps by which two are apart
SURELY = 12.0  # times what may be left open, from which a gain is asked no further: on average chance makes a tenth of it
# Depths, at fewer of which the rounding of each may be anything, and no drawing anew tells how much it feigns: pyramids of holds have 8
# where an encoder reads in steps of 20 µm, and full protocols 36 in steps of 5 µm.
MANY = 15.0
UNEVEN = 0.1  # of a converter's step, which a gain must exceed: motion carries readings across steps, rest does not
INTEGRAL = 0.3  # of a step, rms: a converter's nonlinearity of 0.4 steps up and down
UNFLICKERING = 0.5  # of a step, by which a converter's reading may lag behind
ROUNDED = 0.5  # of a step, by which a tare leaves a zero off
RESOLVED = float(np.hypot(INTEGRAL, ROUNDED))  # of a step: what may be left (RMS) beside that
OF_READING = ("nonlinear_stiffness", "saturation", "dead_zone")  # what bends a reading as the nonlinearity of a converter does
TREMBLING = 1e-6  # m, of a good stage at rest
EVEN_S = 0.5  # over which the speed is averaged, for a beat makes spikes of it
MOVING = 2.0  # times the greatest speed of such a tremble
TRAVEL_S, TRAVELLED = 1.0, 1.5  # within this time the depth of a stage that moves changes by more than so many steps of its encoder
OF_SPEED = ("rate_dependence", "mount_compliance")  # what shows where the stage moves fast: there steps make a speed that is none
CLEARLY = 3.0  # standard deviations of noise
DRIVEN = 0.3  # of what is explained in all, the least that must be while the driving force changes
# What smooths the depth, and with it its steps and noise.
SMOOTHING = ("rate_dependence", "mount_compliance", "stress_relaxation", "hysteresis", "backlash", "lag", "time_shift", "quantization")
DILUTED = 0.15  # of the mean square, plain or whitened, that noise of what drives the test may seem to explain

Part = Callable[[Session], np.ndarray]  # a mask (n,) of the samples that count


def of_the_converter(claim: Claim) -> bool:
    """Whether a good converter may do it: bend the reading by its integral nonlinearity, or loop it by the hysteresis that keeps a
    reading from flickering between two levels."""
    step = converter_step(claim.train, claim.channel)
    loops = [e for e in claim.after.effects if isinstance(e, SensorHysteresis) and (e.cause, e.where) == claim.key]
    if loops:
        return max(loops, key=lambda e: abs(e.relative)).threshold <= UNFLICKERING * step
    return claim.cause in OF_READING and claim.gain.squares <= (INTEGRAL * step) ** 2


def resolved(claim: Claim, noise: Whitener | None, encoder_step: float, strict: bool = False) -> bool:
    """Whether the gain is more than encoder and converters leave open, in all or where the stage moves: one that trembles at rest does so
    no more while it moves. What an encoder may do at most is far more than it does of most causes: where all hangs on it, it is asked what
    it feigns, with the `noise` of the channels; None where the model `after` does not say it all."""
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
    """What white noise of the encoder explains at most, N^2: it averages out within the band, and what smooths the depth, or leaves some of
    the damping to something else, spares the forces what is left of it."""
    train, k, drag = claim.train, stiffness(claim.before, claim.channel), _drag(claim)
    if claim.cause not in SMOOTHING:
        return OPEN * _trembling(train, k, 0.0) ** 2
    # Such a cause also spares the fit what noise of the depth has made of damping.
    return OPEN * _trembling(train, k, drag) ** 2 + (drag * dilution(train) * _speed_rms(train)) ** 2


def _left_open(claim: Claim, encoder_step: float, strict: bool) -> tuple[float, float]:
    """The most that encoder and converters leave open of a channel, N^2, in all and where the stage moves.

    Steps of the encoder leave a force, the same one wherever the plunger comes back to, so that held-out sessions repeat it, and a zero of
    depth, which bends what a free stiffness is fitted to; those of the converter are uneven where noise does not carry the readings across
    them. And damping feels speeds that nobody reads: what depends on speed, or smooths the depth, must exceed what steps beat against
    samples in any session, and those speeds, too, unless the likelihood gains much by it and nobody is `strict`. An error of the depth
    shows in every channel: where a gain is of one alone, and another is left with less than it would be, there is none so large; at a few
    depths the other's own stiffness may have taken it."""
    before, train = claim.before, claim.train
    k, b, drag = stiffness(before, claim.channel), before.dispersion.b1 + before.dispersion.b2, _drag(claim)
    moves, step = partial(_moves, encoder_step), without_noise(encoder_step, train)
    chance = AT_FEW_DEPTHS if held_depths(train, step) < FEW else OPEN
    unzeroed = UNZEROED * step if claim.cause in OF_READING else 0.0
    alone = chance == OPEN and len(claim.gain.carried) == 1 and not claim.driven
    left = [(s, residual(before, s)) for s in train] if alone else []

    def unread(part: Part | None) -> float:
        """Of the depth, m^2."""
        return min(chance * unread_depth(train, step, part) ** 2 + unzeroed**2, _shared_depth(before, claim.channel, left, part) ** 2)

    uneven, by_noise = _uneven(claim), _noise_at_most(claim)
    still, moving = (k**2 * unread(part) + uneven + by_noise for part in (None, moves))
    if claim.cause in OF_SPEED:
        beats = OPEN * max((drag * _beat([s], step)) ** 2 for s in train)
        still, moving = still + beats, moving + beats
        if strict or claim.gain.relative < MUCH:
            resting, passing = ((b * speed) ** 2 for speed in _unread_speeds(train, encoder_step))
            still, moving = still + max(resting, passing), moving + passing
    return still, moving


def _uneven(claim: Claim) -> float:
    """What uneven steps of the channel's converter leave open, N^2."""
    return (UNEVEN * converter_step(claim.train, claim.channel)) ** 2


def _drag(claim: Claim) -> float:
    """The damping of the channel, N s/m, which what smooths the depth may have left to itself."""
    models = (claim.before, claim.after) if claim.cause in SMOOTHING else (claim.before,)
    return max(damping(m, claim.channel) for m in models)


def of_the_drive(claim: Claim) -> bool:
    """Whether noise of the force that drives the test may do what a cause explains: what smooths or delays that force keeps some of its
    noise from the taxels of a simulation, and from those alone (W. A. Fuller, Measurement Error Models, 1987, ch. 1). So it is where a
    channel gains little, and where damping explains it mostly while the force rests."""
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
    """Where the force that drives a test changes by more than its noise does, (n,) in the common band."""
    speed = _speed(s)
    even = _even(speed, s)
    return np.abs(even) > CLEARLY * normal_scale(speed - even)


def unread_depth(sessions: list[Session], encoder_step: float, part: Part | None = None) -> float:
    """What steps q of the depth leave open of it in the common band, m rms: q / sqrt(12) where the stage rests; where it passes n of them
    in half a period of the band's edge their errors average out, and 1 / n of the mean square is left. `part` says which samples count."""

    def squares(s: Session) -> np.ndarray:
        path = np.abs(_speed(s)) / (2.0 * s.band.edge)
        return (encoder_step**2 / 12.0 * np.minimum(1.0, encoder_step / np.maximum(path, 1e-12)))[part(s) if part else slice(None)]

    every = np.concatenate([squares(s) for s in sessions])
    return float(np.sqrt(every.mean())) if every.size else 0.0


def _shared_depth(model: Model, channel: str, left: list[tuple[Session, np.ndarray]], part: Part | None = None) -> float:
    """The largest error of the depth, m rms, that every other channel than this one shows, of which a model has `left` so much (C, n) of
    each session: inf where there is none."""
    power, count = 0.0, 0.0
    for s, e in left:
        counts = s.weight * (part(s) if part else 1.0)
        power, count = power + np.sum(counts * e**2, axis=1), count + np.sum(counts, axis=1)
    rms, channels = np.sqrt(power / np.maximum(count, 1.0)), left[0][0].channels if left else ()
    return min((float(rms[c]) / max(stiffness(model, other), 1e-9) for c, other in enumerate(channels) if other != channel), default=np.inf)


def held_depths(sessions: list[Session], encoder_step: float) -> float:
    """At how many depths of contact the sessions spend their time: 1 / (sum of the squared shares of it)."""
    depth = np.concatenate([s.motion.x[s.motion.x > 0.0] for s in sessions if s.drive is None] or [np.zeros(0)])
    if not (encoder_step and depth.size):
        return np.inf
    _, counts = np.unique(np.round(depth / (APART * encoder_step)), return_counts=True)
    return float(1.0 / np.sum((counts / counts.sum()) ** 2))


def unread_force(model: Model, channel: str, sessions: list[Session], encoder_step: float) -> float:
    """What nobody reads of what drives a test leaves open of a channel, N rms: stiffness times what steps and noise leave of the depth, and
    damping times what they leave of its speed; of a force that drives, its noise, as much as the channel takes of one that is held."""
    step, (k, b) = without_noise(encoder_step, sessions), (of(model, channel) for of in (stiffness, damping))
    steps = np.hypot(k * unread_depth(sessions, step), b * _beat(sessions, step))
    driving = k / max(stiffness(model, "force"), 1e-9) * max(s.drive_noise for s in sessions)
    return float(np.linalg.norm([steps, _trembling(sessions, k, b), driving]))


def without_noise(encoder_step: float, sessions: list[Session]) -> float:
    """The steps of an encoder, m, of what would be as loud as they and its white noise together."""
    return float(np.sqrt(max(encoder_step**2 - 12.0 * max(s.depth_noise for s in sessions) ** 2, 0.0)))


def _trembling(sessions: list[Session], k: float, b: float) -> float:
    """What the white noise of the encoder makes of a force k x + b v in the common band, N rms, of the samples as they were recorded: a
    search looks at fewer, of which each holds less."""

    def force(s: Session) -> float:
        return s.depth_noise * replace(s.band, dt=s.period).passes * float(np.hypot(k, b * _per_length(s.band)))

    return max(force(s) for s in sessions)


def _speed_rms(sessions: list[Session]) -> float:
    """Of the plunger in contact, m/s."""
    squares = np.concatenate([s.motion.v[s.motion.x > 0.0] ** 2 for s in sessions])
    return float(np.sqrt(squares.mean())) if squares.size else 0.0


def _per_length(band: Band) -> float:
    """The speed, 1/s, of what is even up to the edge w of a band: w / sqrt(3) times as much as its depth, rms."""
    return 2.0 * np.pi * band.edge / np.sqrt(3.0)


def _beat(sessions: list[Session], encoder_step: float) -> float:
    """What steps q make of the speed in the common band, m/s rms, where the stage passes nearly a whole number of them a sample: rounding
    is then no noise but a saw of |v / q - n / dt| Hz, of whose harmonics each adds 2 (f q)^2 to the squared speed."""
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
    """What steps of the depth make of its speed within the band, m/s: a stage at rest trembles between them, evenly up to the band's edge;
    one that moves is rounded at every sample, evenly up to half the sampling rate."""
    band, period = sessions[0].band, sessions[0].period
    per_length = _per_length(band) / np.sqrt(12.0)
    return per_length * min(encoder_step, TREMBLING), per_length * encoder_step * float(np.sqrt(2.0 * band.edge * period))


def _fall_in(part: Part, claim: Claim) -> float:
    """Fall of the mean square in the channel at the samples of a part, N^2."""
    fall, count = 0.0, 0.0
    for s, each in zip(claim.train, _falls(claim), strict=True):
        counts = part(s)
        fall += float(np.sum(each * counts))
        count += float(np.sum(s.weight[s.channels.index(claim.channel)] * counts))
    return fall / max(count, 1.0)


def _falls(claim: Claim) -> list[np.ndarray]:
    """Fall of the squares in the channel, N^2, of every sample that is believed, (n,) of each session."""
    rows = [s.channels.index(claim.channel) for s in claim.train]
    return [
        s.weight[row] * (residual(claim.before, s)[row] ** 2 - residual(claim.after, settled(claim.after, s))[row] ** 2)
        for row, s in zip(rows, claim.train, strict=True)
    ]


def _moves(encoder_step: float, s: Session) -> np.ndarray:
    """Where the stage moves faster than it could tremble, (n,) in the common band, and farther than between two readings: at rest on the
    edge of a step the encoder reads a motion that there is not."""
    faster = np.abs(_speed(s)) > MOVING * 2.0 * np.pi * s.band.edge * TREMBLING
    depth, around = np.interp(s.t, s.motion.t, s.motion.x), round(TRAVEL_S / s.band.spacing) | 1
    return faster & (maximum_filter1d(depth, around) - minimum_filter1d(depth, around) > TRAVELLED * encoder_step)


def _even(speed: np.ndarray, s: Session) -> np.ndarray:
    """A speed, averaged over `EVEN_S`."""
    return uniform_filter1d(speed, max(round(EVEN_S / s.band.spacing), 1))


def _speed(s: Session) -> np.ndarray:
    return np.interp(s.t, s.motion.t, s.motion.v)


def unreadable(effects: Iterable[Effect], encoder_step: float) -> float:
    """By what length the tip is said to be off, m, where the encoder could not tell, else 0: it is no more than a step of it, and at a few
    depths to which the stage comes from both sides its rounding alone looks like as much."""
    off = [e for e in effects if e.place is Place.DEPTH]
    lengths = [abs(p.value) for e in off for p in parameters_of(e) if p.role == AMPLITUDE and p.unit == "m"]
    return max(lengths) if lengths and max(lengths) <= encoder_step else 0.0


def converter_step(train: list[Session], channel: str) -> float:
    """The converter's step in a channel, N; zero where none is seen."""
    row = train[0].channels.index(channel)
    return max(s.steps[row] for s in train)
