"""Directions that change the ratios of an array while it is pressed, offered to the search beside those of the catalogue."""

from collections.abc import Iterator
from dataclasses import replace

from skin_ident.criticism.array.bending import Leaning, Reaching, Settling, SettlingReaching, Walking, Widening
from skin_ident.criticism.array.layout import Layout
from skin_ident.criticism.array.smeared import TAUS, Capacitive, Smeared
from skin_ident.criticism.search.proposals import Direction
from skin_ident.criticism.sessions.session import Session
from skin_models.effect import Effect
from skin_models.model import Model
from skin_models.parameter import AMPLITUDE, parameters_of

EARLY = 0.2  # of the greatest depth: initial settling depth of a spread that settles
USUAL = 0.75  # of the greatest depth: where the local share equals the slope over all depths

OF_ARRAY = (Leaning, Walking, Widening, Reaching, Settling, SettlingReaching, Smeared, Capacitive)


def array_directions(layout: Layout | str, session: Session) -> tuple[Direction, ...]:
    """The directions that the layout adds to the catalogue's; none without a layout, nor where force drives the test. Depth and duration
    are those of `session`."""
    if isinstance(layout, str) or session.drive is not None:
        return ()
    return tuple(_direction(e) for e in _effects(layout, session))


def is_of_array(e: Effect) -> bool:
    """Whether an effect belongs to one layout and not to the catalogue."""
    return isinstance(e, OF_ARRAY)


def for_anybody(model: Model) -> Model:
    """The model without the effects that only make sense with a layout: what can be written to file and loaded again."""
    kept = tuple(e for e in model.effects if not is_of_array(e))
    return model if len(kept) == len(model.effects) else replace(model, effects=kept)


def _effects(layout: Layout, session: Session) -> Iterator[Effect]:
    """The effects of the array with zero amplitude, for taxels as seen from the session's contact."""
    taxels = tuple((float(x), float(y)) for x, y in layout.seen)
    seconds, deepest = float(session.motion.t[-1] - session.motion.t[0]), float(session.motion.x.max())
    for axis in layout.axes:
        along = (float(axis[0]), float(axis[1]))
        yield Leaning("rig", taxels, along, layout.width, deepest, shift=0.0)
        yield Walking("rig", taxels, along, layout.width, seconds, shift=0.0)
    if len(taxels) > 2:
        usual = USUAL * deepest
        yield Widening("skin", taxels, layout.width, usual, growth=0.0)
        yield Reaching("skin", taxels, layout.width, usual, growth=0.0)
        for form in (Settling, SettlingReaching):
            yield form("skin", taxels, layout.width, usual, growth=0.0, settling=EARLY * deepest)
        yield from (form("taxel", taxels, share=0.0, tau=tau) for form in (Smeared, Capacitive) for tau in TAUS)


def _direction(e: Effect) -> Direction:
    size = next(p for p in parameters_of(e) if p.role == AMPLITUDE)
    return Direction(e, size.name, abs(size.typical), 0)
