"""What cannot be hidden."""

from skin_models.errors import SkinError


class HidingError(SkinError):
    """An effect that cannot be hidden in a recording."""
