"""What goes wrong with a profile that a person wrote."""

from skin_models.errors import SkinError


class ProfileError(SkinError):
    """A profile cannot be used: a key is wrong or missing, a number is out of range, or the motion leaves the limits."""
