"""Sessions on disk: a tab-separated table with units in its header, and a `rig.yaml` beside it."""

from pathlib import Path

import numpy as np


def write_table(session, path) -> Path:
    """Write `t_s, x_mm, force_n, taxel_0_n, …` with 8 digits (columns that the session lacks are left out) and the folder's rig.yaml."""
    path = Path(path)
    path.parent.mkdir(parents=True, exist_ok=True)
    columns = {"t_s": session.t, "x_mm": None if session.x is None else 1e3 * session.x, "force_n": session.force}
    columns |= {f"taxel_{i}_n": y for i, y in enumerate(session.taxels.T)}
    columns = {name: y for name, y in columns.items() if y is not None}
    np.savetxt(path, np.column_stack(list(columns.values())), "%.8g", "\t", header="\t".join(columns), comments="")
    write_rig(session.rig, path.parent / "rig.yaml")
    return path


def write_rig(rig, path) -> None:
    """What is declared, as flow-style YAML: every value is a number or a list of them."""
    Path(path).write_text("".join(f"{key}: {_yaml(value)}\n" for key, value in rig.items()))


def _yaml(value):
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(map(_yaml, value)) + "]"
    return repr(round(float(value), 10)) if isinstance(value, float) else str(value)


def write_case(sessions, folder) -> list:
    """All sessions of a case as FOLDER/session_0.tsv, …; the paths."""
    return [write_table(s, Path(folder) / f"session_{i}.tsv") for i, s in enumerate(sessions)]
