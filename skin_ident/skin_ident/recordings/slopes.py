"""The slopes that a driver made newtons with: `calibration.yaml`, which the recorder writes into every bag and beside it.

    taxels_n_per_v: {taxel_0: 9.40825}

It is only compared with. What is missing there, or cannot be read, is left out.
"""

from collections.abc import Mapping
from pathlib import Path

import yaml

from skin_ident.recordings.storage import Storage, is_bag

FILE_NAME = "calibration.yaml"


def slopes_in_use(path: Path) -> dict[str, float]:
    """The slope (N/V) of every taxel by name, as the recording at `path` keeps it; empty where it keeps none."""
    beside = (path if path.is_dir() else path.parent) / FILE_NAME
    try:
        return _slopes(yaml.safe_load(beside.read_text(encoding="utf-8") if beside.is_file() else _attached(path)))
    except (OSError, UnicodeDecodeError, yaml.YAMLError):
        return {}


def _attached(path: Path) -> str:
    if not is_bag(path):
        return ""
    with Storage(path) as bag:
        return bag.attachments.get(FILE_NAME, b"").decode("utf-8")


def _slopes(content: object) -> dict[str, float]:
    taxels = content.get("taxels_n_per_v") if isinstance(content, Mapping) else None
    each = taxels.items() if isinstance(taxels, Mapping) else ()
    return {str(name): float(slope) for name, slope in each if isinstance(slope, (int, float)) and slope > 0.0}
