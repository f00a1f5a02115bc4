"""What can go wrong with a report."""

from skin_models.errors import SkinError


class ReportError(SkinError):
    """A report cannot be written, or what it is made from cannot be read."""
