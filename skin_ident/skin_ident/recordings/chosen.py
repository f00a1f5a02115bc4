"""Selects some of the taxels of recordings that have many."""

from collections.abc import Sequence
from dataclasses import replace

from skin_ident.recordings.declared import PER_TAXEL, POSITIONS, Declared
from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.recording import Recording


def only_taxels(recordings: Sequence, names: Sequence[str]) -> list:
    """The recordings with the taxels `names` alone, in that order; a number stands for `taxel_<number>`. Scans pass as they are.

    Raises `RecordingError` for a name that a recording does not have.
    """
    return [_only(r, names) if isinstance(r, Recording) else r for r in recordings]


def _only(r: Recording, names: Sequence[str]) -> Recording:
    known = {name: i for i, name in enumerate(r.taxel_names)}
    wanted = [f"taxel_{name}" if name.isdigit() else name for name in names]
    missing = [name for name in wanted if name not in known]
    if missing:
        some = ", ".join(r.taxel_names[:6]) + (", …" if len(known) > 6 else "")
        raise RecordingError(f"{r.name} has no {missing[0]}; its taxels are {some}")
    if len(set(wanted)) < len(wanted):
        raise RecordingError("--taxels names a taxel twice")
    rows = [known[name] for name in wanted]
    return r.with_taxels(rows, declared=_declared(r.declared, rows, len(known)))


def _declared(d: Declared, rows: list[int], count: int) -> Declared:
    """The declaration with its per-taxel lists reduced to these taxels."""
    lists = {key: getattr(d, key) for key in (*PER_TAXEL, POSITIONS)}
    return replace(d, **{key: tuple(values[i] for i in rows) for key, values in lists.items() if len(values) == count})
