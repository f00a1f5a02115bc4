"""Whether a cause was only a way out of a false minimum, in which the fit without it was caught."""

from skin_ident.criticism.baseline.fitting import Fit, fit
from skin_ident.criticism.search.named import Named
from skin_ident.criticism.search.state import Search

CAUGHT = 0.5  # share of what a cause explains; if the fit without it improves by more, the minimum was the reason


def unstuck(search: Search, after: Fit, finding: Named) -> bool:
    """Refit the present model without the cause, beginning where the fit `after` with it ended. If that improves it by more than half of
    what the cause seemed to explain, take this fit instead of the cause. Return whether it was taken."""
    if finding.key in search.led or search.present.model.having(finding.key):
        return False
    began = fit(after.model.lacking(finding.key), search.train, search.noise).model
    plain = fit(began, search.train, search.noise)  # within bounds that follow from its own stiffness, not from the one it began with
    if search.present.cost - plain.cost < max(search.least(plain.count), CAUGHT * finding.explained):
        return False
    search.led.add(finding.key)  # once each: the noise is estimated anew every time, and a cost may rise again
    search.present = plain
    if not plain.model.effects:
        search.baseline = plain
    return True
