"""The error that a report raises."""

from skin_models.errors import SkinError


class ReportError(SkinError):
    """A report cannot be written, or what it is made from cannot be read."""
