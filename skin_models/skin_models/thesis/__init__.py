"""The thesis's tables as data, and where they disagree with themselves.

Source: "Experimental Testbed for Robot Skin Characterization and Interaction Control", Master's thesis, The University of Texas at
Arlington. The tables stand in `data/thesis`, digit by digit as printed.
"""

from skin_models.thesis.averages import comparisons
from skin_models.thesis.claims import contradicted
from skin_models.thesis.comparison import Comparison, Disagreement, disagreements_of
from skin_models.thesis.copies import copied_rows
from skin_models.thesis.tables import Estimate, Table, scan, table, transfer_functions

__all__ = ["Comparison", "Disagreement", "Estimate", "Table", "disagreements", "scan", "table", "transfer_functions"]


def disagreements() -> list[Disagreement]:
    """Every entry of the thesis's statistics that its own data do not give. (The Gaussian fits: `skin_ident.thesis_spread`.)"""
    return disagreements_of(comparisons()) + copied_rows() + contradicted()
