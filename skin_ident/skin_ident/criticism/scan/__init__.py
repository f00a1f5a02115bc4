"""Criticism of static spread scans: what one taxel feels of a plunger that presses beside it, at several depths.

The method, in the order in which `diagnose_scans` runs it:

1.  `faults` looks at the tables themselves: copied rows, exchanged columns, units, single readings, the steps of the converter.
2.  `family` holds every curve that can be imagined, with the thesis's linear skin and Gaussian spread as its plainest member.
3.  `noise` splits what the richest member leaves into independent noise, placing of columns and repeat of rows (restricted likelihood).
4.  `search` adds causes one by one: likelihood ratio in that noise (`score`), then `gate`: depths and distances left out in turn must be
    predicted better. It exchanges, eliminates, and lists as alternatives what explains nearly as much.
5.  `leftover` asks whether the rest is noise; `limits` says of every other cause what is excluded, and what no static scan can tell.
6.  `extended` writes the result as a model that the simulated skin loads.
"""

from skin_ident.criticism.scan.diagnose import diagnose_scans

__all__ = ["diagnose_scans"]
