"""The lifecycle driver node and the recorder."""

JOINT = "indentation"  # name of the axis in encoder and command
