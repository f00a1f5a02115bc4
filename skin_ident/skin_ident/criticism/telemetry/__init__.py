"""What can be seen in a recording before any model, or in a residual at full rate: the record's own faults.

Each `find_…` finds one cause and returns `Symptom`s. `criticism.record.inspect` runs them, those that look at a residual after a first fit;
what they mark as not to be believed is kept out of every fit that follows.
"""
