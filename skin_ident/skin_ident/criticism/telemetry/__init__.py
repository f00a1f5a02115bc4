"""What can be seen in a recording before any model, or in a residual at full rate: the record's own faults.

Each file finds one cause and returns `Symptom`s. `inspect` runs those that need no model; what they mark as not to be believed is kept
out of every fit that follows.
"""
