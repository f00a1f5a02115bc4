"""Writes the report: all of its files, or none."""

from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path

from skin_ident.criticism.telling.outcome import Outcome
from skin_ident.report.errors import ReportError
from skin_ident.report.markdown import markdown
from skin_ident.report.page import page
from skin_ident.report.story import tell

PICTURES = ("before_after.png", "residual.png", "evidence.png")
PAGE, TEXT = "report.html", "report.md"


def write_report(outcome: Outcome, directory: Path, diagnosis: Path | None = None) -> Path:
    """Write report.html, report.md and the pictures into `directory` (made if needed); returns the path of report.html. `diagnosis` is the
    folder of findings.json and the model, where that is not `directory`.

    Every file is written under a partial name first; all are put in place together, report.html last. Pictures of an earlier report
    that this one does not have are removed. Raises `ReportError` where the directory cannot be written.
    """
    from skin_ident.report.pictures import pictures, save  # imported late: it takes a second, which an early error need not wait for

    directory = Path(directory)
    told = tell(outcome, "" if diagnosis is None or diagnosis.resolve() == directory.resolve() else str(diagnosis.resolve()))
    drawn = pictures(told)
    names = tuple(n for n in PICTURES if n in drawn)
    writers: dict[str, Callable[[Path], None]] = {name: lambda path, name=name: save(drawn[name](), path) for name in names}
    writers[TEXT] = lambda path: _text(path, markdown(told, names))
    writers[PAGE] = lambda path: _text(path, page(told))
    try:
        directory.mkdir(parents=True, exist_ok=True)
        with ExitStack() as cleanup:
            partial = {name: directory / f"{name}.partial" for name in writers}
            for path in partial.values():
                cleanup.callback(path.unlink, missing_ok=True)
            for name, write in writers.items():
                write(partial[name])
            for name, path in partial.items():
                path.replace(directory / name)
        for name in set(PICTURES) - set(names):
            (directory / name).unlink(missing_ok=True)
    except OSError as error:
        raise ReportError(f"cannot write the report into {directory}: {error.strerror or error}") from error
    return directory / PAGE


def _text(path: Path, content: str) -> None:
    path.write_text(content, encoding="utf-8")
