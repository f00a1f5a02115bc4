"""Faults of the record itself, seen in a recording before any model, or in a residual at full rate.

Each `find_…` finds one cause and returns `Symptom`s. `criticism.record.inspect` runs them; those that need a residual run after a first
fit. The samples that they mark as bad are kept out of every fit that follows.

Terms: a sample is calm where the plunger neither makes nor loses contact. A channel has readings of its own where its topic was recorded
at other times than the recording's (see `as_read`). The residual is measured less simulated force, N. "Noise widths" are robust standard
deviations.
"""
