"""Several taxels under one contact: what lies in the ratios of their gains.

A fit with a gain of its own for every taxel can explain any ratio, and so says nothing of a contact that is off its declared place, of one
wrong calibration, of crosstalk, or of a spread of another width or shape. With the places of the taxels declared, all of these show:

1.  `layout`: where taxels and contacts are declared to be, how wide the spread, how sure the calibrations; or why nothing can be said.
    `exchanged`: two columns that were exchanged in all sessions are put right before anything else.
2.  `spreading`: sessions that press at different places bring their own shares along, so that one model can be fitted to all.
3.  `bending`, `smeared`, `proposing`: what changes ratios over depth, time or frequency joins the search as further directions.
4.  `gains`: what is left is static; the share of every taxel in every session, with standard errors, under the extended model.
5.  `family`, `hypotheses`, `evidence`, `judgement`: shares as the declared layout has them, or with one cause more, weighed against
    calibrations and widths that are a little off with nobody to blame.
6.  `gate`: what is sure must also predict held-out sessions better; `findings`, `joining`: it joins the rest of the diagnosis.
"""
