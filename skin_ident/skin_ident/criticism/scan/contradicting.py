"""Whether scans that are fitted together contradict each other, as scans of two skins with different spreads do.

The residual of the joint model is then taken for placing errors, and looks like noise. But each scan fitted by itself, with the same free
parameters, leaves a far smaller residual. With a badly placed plunger or noisy readings, the residual of one scan is as large as that of
all.
"""

from dataclasses import replace

import numpy as np

from skin_ident.criticism.scan.fitting import Member
from skin_ident.criticism.scan.noise import estimate
from skin_ident.criticism.scan.search import Search
from skin_ident.criticism.scan.trials import Setting
from skin_ident.criticism.scan.whitening import Noise
from skin_ident.spread_scan import SpreadScan

ALONE = 0.4  # scans contradict each other where each alone has a noise of at most this share of the joint one
FEWEST = 2.0  # cells per free parameter that a scan needs for an estimate of its own noise


def contradiction(found: Search, s: Setting, scans: list[SpreadScan]) -> str:
    """The warning that scans have no spread in common; empty where they have, or where a scan has too few cells to be fitted alone."""
    numbers = s.cells.scans
    if numbers.size < 2 or any(np.count_nonzero(s.cells.scan == i) < FEWEST * (len(s.rich) + 1) for i in numbers):
        return ""
    together, alone = _size(found.noise.noise), [_alone(found.extended.member, int(i), s) for i in numbers]
    if max(alone) > ALONE * together:
        return ""
    names = " and ".join(scans[i].name for i in numbers)
    return (
        f"{names} have no spread in common: by itself each leaves no more than {max(alone):.2g} N, together {together:.2g} N. They are of "
        "different skins, taxels or places: diagnose each by itself"
    )


def _alone(m: Member, scan: int, s: Setting) -> float:
    """The noise of one scan by itself, N rms, with all excited parameters of the family projected out."""
    cells = s.cells.only(s.cells.scan == scan)
    own = replace(m, k=m.k[[scan]])
    return _size(estimate(own, replace(cells, scan=np.zeros(len(cells), int)), s.rich, s.floor).noise)


def _size(noise: Noise) -> float:
    return float(np.sqrt(np.mean(noise.total() ** 2)))
