"""The one exception base of the suite: its message is a sentence for a person."""


class SkinError(Exception):
    """Something a user can mend. `str(error)` says what is wrong and what to do; command lines print it and exit with 2."""


class ModelError(SkinError):
    """A model, an effect or one of its parameters cannot be used."""


class TableError(SkinError):
    """A table of a recording cannot be read."""
