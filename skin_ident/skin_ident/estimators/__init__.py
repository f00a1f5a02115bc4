"""Estimators: from recordings to parameters, with an uncertainty that holds and a verdict that says what was identifiable."""
