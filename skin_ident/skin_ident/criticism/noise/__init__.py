"""The noise of a recording: autoregressive, correlated between channels, and estimated beside everything that any cause could explain."""
