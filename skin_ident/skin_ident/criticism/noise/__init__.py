"""The noise of a recording: autoregressive, correlated between channels, and fitted to what remains after everything that any cause could
explain is taken out."""
