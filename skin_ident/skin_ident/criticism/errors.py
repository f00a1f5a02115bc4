"""Errors of the criticism, for a user to read."""

from skin_models.errors import SkinError


class DiagnosisError(SkinError):
    """These recordings cannot be diagnosed as they are."""
