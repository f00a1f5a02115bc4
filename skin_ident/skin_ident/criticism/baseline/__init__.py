"""The model that is criticised: its starting values, its unknowns, the joint fit to all sessions, and the residual.

`own_shares` and `settling` give each session its own shares of the taxels where sessions press at different places; `twin` criticises
someone else's recorded simulation instead of a model.
"""
