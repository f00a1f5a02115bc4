"""Runs a diagnosis on recordings of the world of hidden effects, and says whether it was right."""

import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parent))

from world import make_sessions, write_case

from skin_ident.criticism.diagnose import diagnose
from skin_ident.recordings.load import load


@dataclass(frozen=True)
class Seek:
    """One case: what was hidden (None: nothing) and the findings."""

    truth: Any
    findings: dict[str, Any]

    @property
    def names(self) -> list[tuple[str, str]]:
        """Cause and place of every finding; the lone taxel of a recording has no number."""
        return [(f["cause"], _plain(f["where"])) for f in self.findings["findings"]]

    @property
    def right(self) -> bool:
        """The hidden cause is named at its place, or honestly among the alternatives of what is named; a null stays silent."""
        if not self.truth.hidden:
            return not self.names
        hidden = self.truth.hidden[0]
        return any((c, w) == (hidden.cause, _plain(hidden.where)) for c, w in self._with_alternatives())

    @property
    def extra(self) -> list[tuple[str, str]]:
        """Findings that are not what was hidden."""
        causes = {h.cause for h in self.truth.hidden}
        return [n for n in self.names if n[0] not in causes]

    def _with_alternatives(self) -> list[tuple[str, str]]:
        every = [f for finding in self.findings["findings"] for f in (finding, *finding["alternatives"])]
        return [(f["cause"], _plain(f["where"])) for f in every]


def seek(folder: Path, cause: str | None, *, taxels: int = 1, **hidden: Any) -> Seek:
    """Hide `cause`, write three sessions as tables, read them back, and diagnose with the third held out."""
    sessions, truth = make_sessions(cause, n_sessions=3, n_taxels=taxels, **hidden)
    write_case(sessions, folder)
    recordings = load(folder)
    return Seek(truth, diagnose(recordings[:2], recordings[2:]).findings)


def _plain(where: str) -> str:
    return "taxel" if where.startswith("taxel") else where
