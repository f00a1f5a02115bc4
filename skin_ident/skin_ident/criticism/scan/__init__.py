"""Criticism of static spread scans: the force on one taxel while a plunger presses at several distances beside it, at several depths.

The method, in the order in which `diagnose_scans` runs it:

1.  `faults` inspects the tables without a model: copied rows, exchanged columns, wrong units, outliers, converter steps.
2.  `family` defines a parametric family of force curves; the thesis's linear skin with a Gaussian spread is its simplest member.
3.  `noise` fits the richest member and splits its residual into independent noise, placing errors of columns and repeat errors of rows
    (restricted likelihood).
4.  `search` adds causes one by one. Each needs a likelihood ratio in that noise (`score`) and must pass the `gate`: depths and distances
    left out in turn must be predicted better. Named causes may then be exchanged for others or eliminated; causes that explain nearly as
    much are listed as alternatives.
5.  `leftover` tests whether the final residual is noise. `limits` gives an upper bound for every other cause, or says why no static scan
    can test it.
6.  `extended` writes the result as a model that the simulated skin loads.

Terms: a table holds one scan, with a row per depth and a column per distance; a cell is one reading. The model's force is level (a function
of depth) times spread (a function of distance); the size k of a scan is its force at the deepest depth, right over the taxel. A member is
one set of parameter values of the family. The cost of a fit is the sum of squared whitened residuals, and its fall the likelihood gain
(twice nats).
"""

from skin_ident.criticism.scan.diagnose import diagnose_scans

__all__ = ["diagnose_scans"]
