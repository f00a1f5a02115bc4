"""A delay between depth and forces as good hardware has it: filters of amplifiers and converters that take turns are late by some 0.1 ms.

A record of little noise shows such a delay at every touch, where damping steps. It is no finding, but whatever can look like a delay would
stand for it, beside what it is named for. So where it explains most of what the best cause does, the depth of all sessions is taken to be
that late: it belongs to the baseline, as the zeros of tares do. It is asked for again beside whatever is named later.
"""

import numpy as np

from skin_ident.criticism.baseline.fitting import fit
from skin_ident.criticism.search.hardware import delay_does
from skin_ident.criticism.search.state import Search
from skin_ident.criticism.search.survey import Survey
from skin_ident.criticism.sessions.session import delayed
from skin_ident.criticism.vocabulary import LATE_DEPTH
from skin_models.effects.time_shift import TimeShift
from skin_models.parameter import PROMPT

MOSTLY = 0.5  # share of the best cause's score that a delay must explain to be taken
SURE = 2.0  # standard errors by which a delay must exceed what good hardware has to be more than that
CHANGED = 2e-5  # s, change of the delay from which it is taken anew


def settle_lateness(search: Search, last: Survey) -> bool:
    """Take the depth to be late, or late by another time, as far as good hardware is; return whether anything changed. It is asked for
    once beside the same findings and the same baseline, where the survey `last` shows that it may explain enough. A delay that was taken
    need not explain as much again."""
    if not last.ranked:  # every channel is silent
        return False
    beside, taken = (len(search.named), search.zeroed, search.own_skin), search.train[0].late
    least = -np.inf if taken else max(search.least(search.present.count), MOSTLY * last.ranked[0].score)
    shown = max((r.gain for r in last.ranked if r.key == LATE_DEPTH), default=0.0)
    if search.late == beside or shown <= least or search.present.model.having(LATE_DEPTH):
        return False
    search.late = beside
    found = fit(search.present.model.extended(TimeShift("clock_depth")), search.train, search.noise)
    number = len(found.model.effects) - 1
    changed, std = found.model.effects[number].delay, found.std.get(found.model.listed_as(number, "delay"), 0.0)
    whole = taken + changed
    if abs(changed) < CHANGED or abs(whole) > PROMPT + SURE * std or found.score_over(search.present) <= least:
        return False
    search.train, search.held = ([delayed(s, whole) for s in sessions] for sessions in (search.train, search.held))
    search.present = fit(found.model.without(found.model.effects[number]), search.train, search.noise)
    search.tared[LATE_DEPTH] = delay_does(whole)
    search.progress("taking the depth to be as late as good hardware is")
    return True
