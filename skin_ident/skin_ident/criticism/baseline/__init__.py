"""The model that is criticised: where it starts, its unknowns, its joint fit to all sessions, and the residual that it leaves.

`settling` and `own_shares` let sessions that press elsewhere have shares of their own; `twin` takes somebody else's recorded simulation
in its place.
"""
