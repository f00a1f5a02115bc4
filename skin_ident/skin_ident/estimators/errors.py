"""The error that fits raise."""

from skin_models.errors import SkinError


class FitError(SkinError):
    """These recordings cannot be fitted as asked."""
