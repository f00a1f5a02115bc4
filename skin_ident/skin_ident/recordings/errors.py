"""What can be wrong with a recording."""

from skin_models.errors import SkinError


class RecordingError(SkinError):
    """A recording, or the `rig.yaml` beside it, cannot be used."""
