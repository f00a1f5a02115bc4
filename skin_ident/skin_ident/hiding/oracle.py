"""The oracle: a model with exactly the effect that was hidden, fitted to the same sessions."""

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.baseline.residual import residual, rmse
from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.search.proposals import directions
from skin_ident.criticism.search.survey import survey
from skin_ident.criticism.sessions.parting import without_parting
from skin_ident.criticism.sessions.session import prepare
from skin_ident.hiding.hide import Hidden
from skin_ident.recordings.mass import known_mass
from skin_ident.recordings.recording import Recording
from skin_models.model import Model

UNKNOWABLE = ("outliers", "noise", "dead_taxel", "quantization")  # causes that no model predicts: random, or a loss of information
RANDOM = ("random_walk",)  # forms that no model predicts


def oracle_errors(train: list[Recording], held: list[Recording], hidden: Hidden | None) -> dict[str, float] | None:
    """Held-out RMSE (N) of the oracle by channel; None where no model can predict what was hidden."""
    if hidden is not None and (hidden.effect.cause in UNKNOWABLE or hidden.effect.form in RANDOM):
        return None
    fitted, tried = [prepare(r) for r in train], [prepare(r) for r in held]
    start: Model = dispersion_start(fitted, known_mass(train[0].declared).kg)
    fitted, tried = ([without_parting(s, start.dispersion) for s in sessions] for sessions in (fitted, tried))  # as the criticism does
    knowing = start if hidden is None else start.extended(hidden.effect)
    noise = survey(knowing, fitted[:1], directions(fitted[0])).noise
    model = fit(knowing, fitted, noise).model
    return rmse([residual(model, s) for s in tried], tried)
