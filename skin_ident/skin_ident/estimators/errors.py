"""What can be wrong with a fit."""

from skin_models.errors import SkinError


class FitError(SkinError):
    """These recordings cannot be fitted as asked."""
