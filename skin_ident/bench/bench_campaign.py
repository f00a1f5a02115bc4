"""Hide and seek in small: how often the criticism is right, silent, or wrong on recordings of a world written apart from its models.

`test/campaign.py` runs the same by the hundred, with any seed, size and cause.
"""

import os
import sys
from pathlib import Path

for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ.setdefault(name, "1")
sys.path.insert(0, str(Path(__file__).parent.parent / "test"))

import campaign

KINDS = (
    ("nothing hidden, encoders of 1 to 20 um", ("null", "--count", "20")),
    ("every cause once, as large as the noise", ("single", "--count", "22")),
    ("every cause once, half as large", ("single", "--size", "0.5", "--count", "22", "--seed", "1")),
    ("pairs, half as large again", ("pair", "--size", "1.5", "--count", "8")),
    ("poor protocols", ("poor", "--count", "12")),
)


def main() -> None:
    """Print every case and the rates."""
    for title, arguments in KINDS:
        print(f"\n{title}", flush=True)
        campaign.main(list(arguments))


if __name__ == "__main__":
    main()
