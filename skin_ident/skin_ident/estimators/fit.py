"""One call for all fits: the kind of recordings decides which estimator is used, `Options` decides the rest."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from skin_ident.estimators.dispersion import FREE, fit_dispersion
from skin_ident.estimators.errors import FitError
from skin_ident.estimators.estimate import FIXED, Estimate, Verdict
from skin_ident.estimators.force_to_force import fit_force_to_force
from skin_ident.estimators.robust import LINEAR
from skin_ident.estimators.sinusoid import as_sinusoids
from skin_ident.recordings.assemble import counts_seconds
from skin_ident.recordings.mass import KnownMass, known_mass
from skin_ident.recordings.recording import Recording
from skin_ident.recordings.repeated import without_repeats
from skin_models.signals import Motion

HEAVY = 1e3  # kg, more than any skin has
MEASURED, SINUSOID = "measured", "sinusoid"


@dataclass(frozen=True)
class Options:
    """`mass`: free, fixed (see `known_mass`), or a number in kg; `thickness_mm`: of the skin, for the fixed mass; `motion`: as measured, or
    the sinusoid fitted to it; `offsets`: fit a zero offset per channel and session; `order`: of the transfer function from force to force;
    `loss`: one of `robust.LOSSES`; `keep_spikes`: do not bridge spikes.
    """

    mass: str = FIXED
    thickness_mm: float | None = None
    motion: str = MEASURED
    offsets: bool = False
    order: int = 1
    loss: str = LINEAR
    keep_spikes: bool = False

    def of(self, recordings: Sequence[Recording]) -> list[Recording]:
        """The recordings to fit: without repeated ones, and marked to keep their spikes if `keep_spikes`."""
        once = without_repeats(recordings)
        return [replace(r, keeps_spikes=True) for r in once] if self.keep_spikes else once


def fit_recordings(recordings: Sequence[Recording], options: Options = Options()) -> Estimate:
    """The dispersion model fitted to all sessions together; from force to force where none of them has a depth. Raises `FitError`.

    A session that is given twice counts once.
    """
    return fit_prepared(options.of(recordings), options)


def fit_prepared(recordings: Sequence[Recording], options: Options) -> Estimate:
    """The same for recordings that `Options.of` has prepared."""
    if all(r.depth is None for r in recordings):
        return fit_force_to_force(recordings, options.order, loss=options.loss)
    known = held_mass(options, recordings)
    estimate = _fitted(recordings, FREE if known is None else known.kg, options)
    held = {"m": Verdict(FIXED, f"held at {known.source}")} if known else {}
    return replace(estimate, verdicts={**estimate.verdicts, **held})


def _fitted(recordings: Sequence[Recording], mass: float | str, options: Options) -> Estimate:
    if options.motion == MEASURED:
        return fit_dispersion(recordings, mass, offsets=options.offsets, loss=options.loss)
    parts, motions, found = as_sinusoids(recordings)
    how = {"offsets": options.offsets, "loss": options.loss, "method": "linear least squares on fitted sinusoids"}
    estimate = fit_dispersion(parts, mass, motions, **how)
    return replace(estimate, notes={**estimate.notes, "sinusoids": {r.name: vars(s) for r, s in zip(recordings, found, strict=True)}})


Fitted = tuple[list[Recording], float | str, list[Motion] | None]  # recordings, mass, and motions that are not as measured


def as_fitted(recordings: Sequence[Recording], options: Options) -> Fitted:
    """Recordings, mass and motions (None: as measured) with which a depth-driven fit of `options` is made. Raises `FitError`."""
    mass = mass_of(options, recordings)
    if options.motion == MEASURED:
        return list(recordings), mass, None
    parts, motions, _ = as_sinusoids(recordings)
    return parts, mass, motions


def mass_of(options: Options, recordings: Sequence[Recording]) -> float | str:
    """FREE, or the mass in kg. Raises `FitError` for a text that is neither."""
    known = held_mass(options, recordings)
    return FREE if known is None else known.kg


def held_mass(options: Options, recordings: Sequence[Recording]) -> KnownMass | None:
    """The mass that is held, and its source; None where it is free. Raises `FitError` for a text that is no mass."""
    check(options)
    if options.mass in (FREE, FIXED):
        return None if options.mass == FREE else known_mass(recordings[0].declared, options.thickness_mm)
    return KnownMass(float(options.mass), "what was asked for")


def check(options: Options) -> None:
    """Raises `FitError` for a thickness or a mass that no skin has, and for a text that is no mass."""
    thick = options.thickness_mm
    if thick is not None and not 0.0 < thick < 1e3:
        raise FitError(f"a skin is not {thick:g} mm thick")
    if options.mass in (FREE, FIXED):
        return
    try:
        mass = float(options.mass)
    except ValueError:
        raise FitError(f"the mass is {FREE}, {FIXED}, or a number in kg, not {options.mass!r}") from None
    if not 0.0 <= mass < HEAVY:
        raise FitError(f"the mass is in kg, from 0 up and below {HEAVY:g}, not {options.mass}")


def sessions_of(loaded: Sequence) -> tuple[list[Recording], list[str]]:
    """The sessions among what was loaded, and the names of static scans. Raises `FitError` where there are only scans, and
    `RecordingError` where the time may be in milliseconds."""
    sessions = [r for r in loaded if isinstance(r, Recording)]
    scans = [r.name for r in loaded if not isinstance(r, Recording)]
    if not sessions:
        raise FitError(f"{scans[0]} is a static spread scan, which has no dispersion model: fit scans alone, or give it to diagnose")
    for r in sessions:
        counts_seconds(r)
    return sessions, scans
