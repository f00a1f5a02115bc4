"""`report DIR`: renders the report of an earlier `diagnose` again, from what it left in its output directory."""

import sys
from collections.abc import Sequence
from pathlib import Path

from skin_ident.cli.common import Parser, run
from skin_ident.report import load_outcome, write_report


def report(arguments: Sequence[str] | None = None) -> int:
    """Parse the arguments, render, and say where the page lies. Returns the exit status; raises `ReportError` for an unusable directory."""
    parser = Parser(prog="report", description="Render the report of a diagnosis again, without fitting anything.")
    parser.add_argument("directory", type=Path, metavar="DIR", help="what diagnose wrote with --out: findings.json and traces.npz")
    parser.add_argument("--out", type=Path, metavar="DIR", help="where to write the report (default: the same directory)")
    given = parser.parse_args(arguments)
    print(write_report(load_outcome(given.directory), given.out or given.directory, given.directory))
    return 0


def main() -> int:
    """Entry point."""
    return run(report)


if __name__ == "__main__":
    sys.exit(main())
