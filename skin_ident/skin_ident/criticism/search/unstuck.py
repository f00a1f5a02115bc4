"""Whether a cause was only a way out of a minimum in which the fit without it was caught."""

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.search.growing import instances, lacking
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search

CAUGHT = 0.5  # of what a cause explains, from which the minimum was the cause


def unstuck(search: Search, after: Fit, finding: Named) -> bool:
    """Whether the model so far comes closer than it had, begun where the fit `after` with a cause has taken it, by more than half of what
    that cause seemed to explain, and was taken from there."""
    if finding.key in search.led or instances(search.present.model, *finding.key):
        return False
    began = fit(lacking(after.model, *finding.key), search.train, search.noise).model
    plain = fit(began, search.train, search.noise)  # within bounds of its own stiffness, not of that which it began with
    if search.present.cost - plain.cost < max(search.least(plain.count), CAUGHT * finding.explained):
        return False
    search.led.add(finding.key)  # once each: the noise is seen anew every time, and a cost may rise again
    search.present = plain
    if not plain.model.effects:
        search.baseline = plain
    return True
