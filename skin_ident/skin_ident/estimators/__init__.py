"""Estimators: from recordings to parameters, with realistic standard errors and a verdict on which parameters were identifiable."""
