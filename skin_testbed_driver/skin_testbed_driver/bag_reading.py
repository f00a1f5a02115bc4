"""The records of an MCAP file as far as they can be read, and what cannot be: a file that ends in the middle, chunks that are damaged."""

import os
from collections.abc import Iterator
from pathlib import Path

from mcap.records import Chunk, DataEnd, McapRecord
from mcap.stream_reader import StreamReader, breakup_chunk

from skin_models.words import counted
from skin_testbed_driver.rig import RigError

_MAGIC = b"\x89MCAP0\r\n"


def records(file: Path, faults: list[str]) -> Iterator[McapRecord]:
    """Every record of the data section; what is lost is added to `faults`. Raises `RigError` for a file that is no MCAP file."""
    damaged = 0
    try:
        with file.open("rb") as stream:
            _check_magic(file, stream.read(len(_MAGIC)))
            for record in StreamReader(stream, skip_magic=True, emit_chunks=True).records:
                if isinstance(record, DataEnd):
                    break  # the summary behind it repeats what was there
                if not isinstance(record, Chunk):
                    yield record
                elif (within := _within(record)) is None:
                    damaged += 1
                else:
                    yield from within
    except OSError as error:
        raise RigError(f"cannot read {file}: {error.strerror}") from error
    except RigError:
        raise
    except Exception:  # half a record, as flipped bits outside of chunks, makes any error of the library's
        faults.append(f"{file.name} {'is damaged and can be read no further' if _is_whole(file) else 'is cut off'}")
    if damaged:
        faults.append(f"{file.name} has {counted(damaged, 'damaged chunk')}, left out")


def _check_magic(file: Path, head: bytes) -> None:
    if head != _MAGIC:
        raise RigError(f"{file} is {'not an MCAP file' if head else 'empty'}")


def _is_whole(file: Path) -> bool:
    """Whether a file ends as one that was closed."""
    with file.open("rb") as stream:
        stream.seek(-len(_MAGIC), os.SEEK_END)
        return stream.read() == _MAGIC


def _within(chunk: Chunk) -> list[McapRecord] | None:
    """What a chunk holds; None where its bytes are not those that were written."""
    try:
        return breakup_chunk(chunk, validate_crc=True)
    except Exception:  # each compression has errors of its own
        return None
