"""An MCAP file gives what it holds, whole, without its index, cut off or damaged, and says what was lost."""

import subprocess
import sys
from functools import partial

import making
import numpy as np
import pytest
from making import recording, same, write_bag, write_mcap
from mcap.writer import IndexType
from mcap.writer import Writer as McapWriter

from skin_ident.recordings.errors import RecordingError
from skin_ident.recordings.load import load
from skin_ident.recordings.mcap_file import survey
from skin_ident.recordings.recording import Recording

R = recording(n=300, shares=(1.0, 0.4))


def records(data):
    """Opcode, start and size of every record of an MCAP file."""
    at = 8
    while at + 9 <= len(data) - 8:
        op, size = data[at], int.from_bytes(data[at + 1 : at + 9], "little")
        yield op, at, 9 + size
        at += 9 + size


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
@pytest.mark.parametrize("share", [0.3, 0.77, 0.98])
def test_truncated_mcap_gives_what_it_holds(tmp_path, compression, share):
    data = write_mcap(tmp_path / "a.mcap", R, compression).read_bytes()
    (tmp_path / "a.mcap").write_bytes(data[: int(share * len(data))])
    r = load(tmp_path / "a.mcap")[0]
    assert 0.5 * share * len(R) < len(r) <= len(R) and (len(r) == len(R) or "cut off" in " ".join(r.warnings))
    assert all(np.array_equal(a[..., : len(r)], b) for a, b in ((R.depth, r.depth), (R.force, r.force), (R.taxels, r.taxels)))


def test_mcap_without_summary_or_index_reads_the_same(tmp_path):
    data = write_mcap(tmp_path / "a.mcap", R, "LZ4").read_bytes()
    kept = b"".join(data[at : at + size] for op, at, size in records(data) if op not in (7, 8, 11, 14, 2, 10, 13))
    (tmp_path / "b.mcap").write_bytes(data[:8] + kept)
    assert same(load(tmp_path / "b.mcap")[0], R, 1e-15)


def test_mcap_without_message_indexes_reads_the_same(tmp_path, monkeypatch):
    monkeypatch.setattr(making, "McapWriter", partial(McapWriter, index_types=IndexType.ALL & ~IndexType.MESSAGE))
    assert same(load(write_mcap(tmp_path / "a.mcap", R))[0], R, 1e-15)


def test_mcap_without_chunks_reads_the_same(tmp_path):
    r = load(write_mcap(tmp_path / "a.mcap", R, use_chunking=False))[0]
    assert same(r, R, 1e-15) and r.warnings == ()


def test_damaged_chunk_is_left_out_and_counted(tmp_path):
    data = bytearray(write_mcap(tmp_path / "a.mcap", R).read_bytes())
    chunks = [(at, size) for op, at, size in records(data) if op == 6]
    at, size = chunks[len(chunks) - 2]
    data[at + size // 2] ^= 0x10
    (tmp_path / "a.mcap").write_bytes(data)
    said = " ".join(load(tmp_path / "a.mcap")[0].warnings)
    assert "1 damaged chunk" in said and "lost" in said


def test_a_file_that_is_damaged_in_the_middle_is_not_said_to_be_cut_off(tmp_path):
    """What a walk through a damaged file cannot reach is said to be unread; a damaged chunk that it can pass is counted alone."""
    data = bytearray(write_mcap(tmp_path / "a.mcap", R, chunk_size=2000).read_bytes())
    chunks = [(at, size) for op, at, size in records(data) if op == 6]
    at, size = chunks[len(chunks) // 2]
    broken = data[:at] + bytes([0xEB]) * 64 + data[at + 64 : -28] + bytes(20) + data[-8:]
    (tmp_path / "a.mcap").write_bytes(broken)
    said = " ".join(load(tmp_path / "a.mcap")[0].warnings)
    assert f"a.mcap is damaged at byte {at}: the {len(broken) - at} bytes from there on are not read" in said and "cut off" not in said
    data[at + size // 2] ^= 0x10
    data[-28:-8] = bytes(20)
    (tmp_path / "a.mcap").write_bytes(data)
    said = " ".join(load(tmp_path / "a.mcap")[0].warnings)
    assert "damaged chunk" in said and "cut off" not in said


@pytest.mark.parametrize("library", ["zlib_ng.zlib_ng", "binascii"])
def test_checksums_are_the_same_with_and_without_zlib_ng(tmp_path, library):
    """A bag that is whole has no word said about it, one with a flipped bit has, whichever library takes the checksums."""
    if library != "binascii":
        pytest.importorskip(library)
    program = (
        "import sys\n"
        "if sys.argv[1] == 'binascii': sys.modules['zlib_ng'] = None\n"
        "from skin_ident.recordings import load, mcap_chunk\n"
        "assert mcap_chunk.crc32.__module__ == sys.argv[1], mcap_chunk.crc32.__module__\n"
        "print([len(load.load(path)[0].warnings) for path in sys.argv[2:]])"
    )
    whole = write_mcap(tmp_path / "a.mcap", R, chunk_size=5000)
    data = bytearray(whole.read_bytes())
    at, size = [(at, size) for op, at, size in records(data) if op == 6][-2]
    data[at + size // 2] ^= 0x10
    (tmp_path / "b.mcap").write_bytes(data)
    done = subprocess.run([sys.executable, "-c", program, library, whole, tmp_path / "b.mcap"], capture_output=True, text=True, timeout=60)
    assert done.stdout.startswith("[0, ") and not done.stdout.startswith("[0, 0]"), done.stderr


@pytest.mark.parametrize(
    ("content", "says"), [(b"", "empty"), (b"\x89MCAP0\r\n", "damaged, or cut off"), (b"hello, I am no bag", "not an MCAP file")]
)
def test_file_that_is_no_mcap(tmp_path, content, says):
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(RecordingError, match=says):
        load(tmp_path / "a.mcap")


def test_a_bag_that_lost_its_file_is_told_from_an_empty_folder(tmp_path):
    for file in write_bag(tmp_path / "bag", R).glob("*.mcap"):
        file.unlink()
    with pytest.raises(RecordingError, match=r"its recording file \(\.mcap or \.db3\) is missing"):
        load(tmp_path / "bag")


def damaged(data, rng):
    """A file with some wrong bytes, mostly at its end, or cut off; every second time without the checksum that would tell."""
    data = bytearray(data)
    if rng.random() < 0.5:
        data[-12:-8] = bytes(4)
    if rng.random() < 0.2:
        data = data[: rng.integers(60, len(data))]
    least = max(8, len(data) - 1500) if rng.random() < 0.6 else 8
    for at in rng.integers(least, len(data), rng.integers(1, 6)):
        data[at] = rng.choice([0, 1, 127, 255, rng.integers(256)])
    return data


@pytest.mark.parametrize("how", ["NONE", "LZ4", "ZSTD", "without chunks"])
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_damaged_file_is_read_or_refused_in_one_sentence(tmp_path, how):
    options = {"use_chunking": False} if how == "without chunks" else {"compression": how}
    data = write_mcap(tmp_path / "a.mcap", recording(n=60, shares=(1.0, 0.4)), chunk_size=4000, **options).read_bytes()
    outcomes, rng = [], np.random.default_rng(7)
    for _ in range(150):
        (tmp_path / "a.mcap").write_bytes(damaged(data, rng))
        try:
            outcomes += load(tmp_path / "a.mcap")
        except RecordingError as error:
            assert "\n" not in str(error)
            outcomes.append(str(error))
    assert {Recording, str} == set(map(type, outcomes))


def test_a_summary_that_is_damaged_is_not_believed(tmp_path):
    """Its checksum tells; without one, what cannot be: more messages than bytes, a chunk beyond the end."""
    data = write_mcap(tmp_path / "a.mcap", R).read_bytes()
    assert any(data[-12:-8]) and survey(tmp_path / "a.mcap").indexed
    counts, chunk = (next(at for op, at, _ in records(data) if op == wanted) for wanted in (11, 8))
    for at, value, unsummed in ((counts + 9 + 46 + 2, 7, False), (counts + 9 + 46 + 8, 7, True), (chunk + 9 + 16 + 6, 7, True)):
        spoilt = bytearray(data)
        spoilt[at] = value
        spoilt[-12:-8] = bytes(4) if unsummed else data[-12:-8]
        (tmp_path / "a.mcap").write_bytes(spoilt)
        assert not survey(tmp_path / "a.mcap").indexed and same(load(tmp_path / "a.mcap")[0], R, 1e-15)
