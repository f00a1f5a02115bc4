"""What of the sessions can be compared with a model."""

from skin_ident.criticism.baseline.start import dispersion_start
from skin_ident.criticism.sessions.beginning import at_rest
from skin_ident.criticism.sessions.parting import moved, without_meeting_at, without_parting
from skin_ident.criticism.sessions.session import Session
from skin_ident.criticism.sessions.surface import surface_of
from skin_models.model import Model


def comparable(train: list[Session], held: list[Session], start: Model, model: Model) -> tuple[list[Session], list[Session]]:
    """The sessions without what cannot be compared: moments when the plunger may have left the skin of `start`; where the surface may lie
    elsewhere than declared, moments when the plunger may have met or left it there; and beginnings at which the skin of `model` is not yet
    at rest."""
    surface = surface_of(train)
    there = dispersion_start([moved(s, surface) for s in train], start.dispersion.m).dispersion if surface else None

    def of(session: Session) -> Session:
        session = at_rest(without_parting(session, start.dispersion), model)
        return without_meeting_at(session, surface, there) if there else session

    return [of(s) for s in train], [of(s) for s in held]
