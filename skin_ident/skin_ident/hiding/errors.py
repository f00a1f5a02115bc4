"""The error for effects that cannot be hidden."""

from skin_models.errors import SkinError


class HidingError(SkinError):
    """An effect cannot be hidden in a recording."""
