"""The model that is criticised, and its fit to the sessions.

- `start`: first values, by linear least squares
- `unknowns`: the unknowns of a model as one vector, with bounds and scales
- `residual`: measured minus simulated, its RMS, and the model as it holds in one session
- `fitting`: the joint fit to all sessions, its cost and standard errors

Where sessions press at different places, each has its own shares of the taxels:

- `own_shares`: these shares under any model, by linear regression
- `settling`: the same by iteration, under effects on the readings of taxels

And besides:

- `living`: shares of taxels that died part-way, from the time when they lived
- `twin`: someone else's recorded simulation, criticised instead of a model
- `twin_clock`: the clock of such a simulation, set to that of its recording
"""
