"""The search for causes: what each would change (`proposals`), how much of the residual that explains (`ranking`, `survey`), the best few
fitted with everything else (`growing`, `trial`), their rivals, the loop over all of it (`criticise`), and what remains excluded (`bounds`).
"""
