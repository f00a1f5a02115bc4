"""`effects_gallery OUT.html`: write the page of all effects."""

import argparse
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from skin_models.errors import SkinError
from skin_models.gallery import TITLE
from skin_models.whole_file import whole_file

APART = 5.0  # s, between two lines of a log
HEAD = 1000  # characters, within which a page has its title


def main(arguments: list[str] | None = None) -> int:
    """Write the page whole or not at all. Returns the exit status: 2 where it cannot be written."""
    parser = argparse.ArgumentParser(prog="effects_gallery", description="Write one HTML page with a picture of every effect.")
    parser.add_argument("out", type=Path, help="the file to write, such as effects.html")
    out = parser.parse_args(arguments).out
    try:
        _write(out)
    except (SkinError, OSError) as error:
        print(f"effects_gallery: {getattr(error, 'strerror', None) or error}: {out}", file=sys.stderr)
        return 2
    print(f"wrote {out}")
    return 0


def _write(out: Path) -> None:
    if not out.parent.is_dir() or out.is_dir():
        raise SkinError("there is no folder to write this file into" if not out.is_dir() else "a folder has that name; name a file")
    if out.suffix.lower() != ".html":
        raise SkinError("the page is HTML: give it a name that ends in .html")
    if out.exists() and TITLE not in out.read_text(encoding="utf-8", errors="replace")[:HEAD]:
        raise SkinError("this file is no gallery, and only an earlier gallery is overwritten: choose another name")
    from skin_models.gallery.page import page  # matplotlib: not before the arguments are known to be right
    from skin_models.gallery.scene import pictures

    with _progress() as say, whole_file(out) as partial:
        partial.write_text(page(list(pictures(say)), say), encoding="utf-8")


@contextmanager
def _progress() -> Iterator[Callable[[str], None]]:
    """Says on stderr what is done: every stage in place on a terminal, which is then left clear; in a log a line now and then."""
    started, live = time.monotonic(), sys.stderr.isatty()
    due = 0.0

    def say(stage: str) -> None:
        nonlocal due
        passed = time.monotonic() - started
        if not live and passed < due:
            return
        due = passed + APART
        text = f"[{passed:5.1f} s] {stage}"
        print(f"\r\033[K{text}" if live else text, end="" if live else "\n", file=sys.stderr, flush=True)

    try:
        yield say
    finally:
        print("\r\033[K" * live, end="", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
