"""Several taxels under one contact: what the ratios of their readings show.

A fit with a free share for every taxel explains any ratio. It therefore cannot show a contact that is off its declared place, one wrong
calibration, crosstalk, or a spread of another width or shape. With declared positions of the taxels all of these show:

1.  `layout`: declared places of taxels and contacts, the width of the spread, the uncertainty of calibrations; or the reason why nothing
    can be judged. `exchanged`: two columns that are exchanged in all sessions, or in one, are corrected before anything else.
2.  `spreading`: sessions that press at different places carry their own shares, so that one model can be fitted to all.
3.  `bending`, `smeared`, `proposing`: effects that change the ratios over depth, time or frequency join the search as further directions.
4.  `gains`: the rest is static. The share of every taxel in every session is estimated with standard errors, under the extended model.
    `scatter` widens these by how much sessions at one place differ.
5.  `family`, `hypotheses`, `evidence`, `judgement`: Bayesian comparison of the shares of the declared layout with those under one further
    cause, against a background of small errors of calibration and width that nobody is to blame for.
6.  `gate`: a cause that is sure must also predict held-out sessions better. `findings`, `sentences`, `extending`, `joining`: it becomes
    part of the diagnosis and of the extended model.
"""
