"""`effects_gallery OUT.html`: write the page of all effects."""

import argparse
import sys
from pathlib import Path

from skin_models.errors import SkinError
from skin_models.gallery import TITLE
from skin_models.whole_file import whole_file

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

    with whole_file(out) as partial:
        partial.write_text(page(list(pictures())), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
