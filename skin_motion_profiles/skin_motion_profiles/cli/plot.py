"""Draw profiles without moving anything.

    ros2 run skin_motion_profiles plot                                 an example of every profile
    ros2 run skin_motion_profiles plot full depth_mm=0.8 --out full.png
"""

import argparse
import sys
from pathlib import Path

from skin_models.errors import SkinError
from skin_motion_profiles.picture import draw, gallery
from skin_motion_profiles.profile_file import entry_from_words

_ENDINGS = (".png", ".svg", ".pdf")


def main() -> None:
    """Entry point."""
    parser = argparse.ArgumentParser(prog="plot", description="Draw a profile, a battery, or an example of every profile.")
    parser.add_argument("profile", nargs="?", help="a YAML file, the name of a battery, or YAML text; left out: every profile")
    parser.add_argument("settings", nargs="*", metavar="key=value", help="arguments of a battery, parameters of a profile")
    parser.add_argument("--out", type=Path, default=Path("profiles.png"), help="picture to write (.png, .svg or .pdf)")
    options = parser.parse_args()
    try:
        if options.out.suffix not in _ENDINGS:
            raise SkinError(f"--out {options.out} must end in {', '.join(_ENDINGS)}")
        entry = None if options.profile is None else entry_from_words(options.profile, options.settings)
        draw({entry.label: entry} if entry else gallery(), options.out)
    except OSError as error:
        sys.exit(_complain(f"cannot write {options.out}: {error.strerror}"))
    except (SkinError, ImportError) as error:
        sys.exit(_complain(str(error)))
    print(options.out)


def _complain(sentence: str) -> int:
    print(f"plot: {' '.join(sentence.split())}", file=sys.stderr, flush=True)
    return 2


if __name__ == "__main__":
    main()
