"""The error that reading a recording raises."""

from skin_models.errors import SkinError


class RecordingError(SkinError):
    """A recording, or the `rig.yaml` beside it, cannot be used."""
