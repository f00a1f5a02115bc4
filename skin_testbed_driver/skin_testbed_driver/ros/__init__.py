"""The lifecycle driver node and the recorder."""
