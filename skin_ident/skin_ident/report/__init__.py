"""The report of a diagnosis: one page that opens offline, the same in markdown, and pictures.

`write_report(outcome, directory)` writes it; `save_traces(outcome, directory)` keeps the curves, so that `load_outcome(directory)` and
the command `report DIR` can render it again without fitting anything. Everything else in this package is private to the report.
"""

from skin_ident.report.errors import ReportError
from skin_ident.report.store import load_outcome, load_traces, save_traces
from skin_ident.report.write import write_report

__all__ = ["ReportError", "load_outcome", "load_traces", "save_traces", "write_report"]
