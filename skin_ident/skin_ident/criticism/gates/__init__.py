"""What a cause must pass before it is believed: held-out sessions predicted better (`gate`), beside what training leaves uncertain
(`uncertain`), what the steps of the converters leave open (`resolution`), and what noise of another colour would explain (`description`).
"""
