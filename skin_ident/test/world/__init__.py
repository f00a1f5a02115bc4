"""A testbed of its own that hides effects in recordings, written apart from everything that will be fitted to them."""

from .hidden import PLACES, Hide, forms
from .noise import Noise
from .sessions import Session, Truth, make_sessions, without
from .tables import write_case, write_table

__all__ = ["PLACES", "Hide", "Noise", "Session", "Truth", "forms", "make_sessions", "without", "write_case", "write_table"]
