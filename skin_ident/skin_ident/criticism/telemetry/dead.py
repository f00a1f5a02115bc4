"""Dead taxels: stuck at one value, open from the start, dying part-way, or on and off, where the load says that they should have moved.

Where nothing moves, nothing is asked of a taxel. A taxel far from the plunger reads nothing and is not dead: unless it is the only one, its
place must promise it a reading (see `promise`). Behind a coarse converter it may hold one value, zero, for as long as anybody records.
"""

import numpy as np

from skin_ident.criticism.pattern import in_sessions, listed
from skin_ident.criticism.telemetry.loose import contact_of
from skin_ident.criticism.telemetry.promise import least_step, promised
from skin_ident.criticism.telemetry.still import is_still
from skin_ident.criticism.telemetry.symptom import Symptom, quantity, sensor_of

FOLLOWS = 0.2  # correlation with the load below which a taxel does not follow it: noise that wanders may have half of that
FOLLOWED = 0.3  # correlation from which it follows in a session: some pieces may seem to by chance
PIECES = 24  # pieces into which a session is cut
MOVED = 0.2  # load's standard deviation in a piece, as a share of that in the session, from which the piece is tested
ALIVE = 0.3  # share of the usual slope from which a taxel is alive in a piece
GONE = 0.03  # share of the usual slope up to which it is dead in a piece
SURE = 0.8  # correlation in a piece from which it surely follows
FAINTLY = 0.5  # the same for each of FEWEST pieces, where a taxel feels little more than its noise
FEWEST = 4  # tested dead pieces in a row up to the end of the session; or a long stretch under a load that changes much
PROMISED = 5.0  # converter steps, rms, by which a taxel should have moved if a constant reading is to count
WHOLE = 0.8  # share of the usual slope, down to which it does not fade yet
ALIKE = 0.6  # least ratio of a taxel's slopes in two sessions at the same place
LONG = 20  # samples at rest, at least, that show whether a converter hides the noise
MUCH = 0.5  # load's standard deviation, as a share of that in the session, that is much


def find_dead_taxels(recordings: list) -> list[Symptom]:
    """Taxels that are silent in all sessions, on and off, or that fall silent in some."""
    n = len(recordings[0].taxels)
    return [s for i in range(n) for s in (_silent(recordings, i, n) or _loose(recordings, i, n) or _dying(recordings, i, n))]


def _silent(recordings: list, i: int, n: int) -> list[Symptom]:
    """A taxel that holds one value in all sessions, or does not follow the load in any though its place or its neighbours promise that it
    should."""
    name = f"taxel_{i}"
    rows = [r.taxels[i] for r in recordings]
    loads = [_load(r) for r in recordings]
    if all(load is None for load in loads):
        return []
    if all(np.ptp(row) == 0.0 for row in rows) and not _may_be_far(recordings, i, n):
        level = float(rows[0][0])
        holds = f"{level:.4g}" if level else "0, or no number at all,"
        unread = "" if level else ": it is open, or was not recorded"
        return [_symptom(name, n, 0.0, f"{name} holds {holds} in all {sum(map(len, rows))} samples{unread}", "stuck", level)]
    if any(load is None for load in loads):
        return []
    r = _follows(loads, rows)
    by = promised(recordings, i, n) if r < FOLLOWS else ""
    if not by:
        return []
    level = float(np.median(np.concatenate(rows)))
    kind = "stuck" if abs(level) > 3.0 * float(np.std(rows[0])) else "open"
    follows = f"{name} does not follow the load in any of {len(rows)} sessions (largest correlation {r:.2f})"
    why = f"{follows}, {by}; it reads {level:.3g} N throughout"
    return [_symptom(name, n, 0.0, why, kind, level)]


def _may_be_far(recordings: list, i: int, n: int) -> bool:
    """Whether a taxel that holds one reading may only be too far away for its converter: it reads nothing, no place promises it more, and
    the converters of others that live hide their noise at rest, too; if there is no rest, its declared place must say so."""
    alive = [k for k in range(n) if k != i and any(np.ptp(r.taxels[k]) > 0.0 for r in recordings)]
    if not alive or promised(recordings, i, n):
        return False
    level = max(abs(float(r.taxels[i][0])) for r in recordings)
    others = (r.taxels[alive][:, _at_rest(r)] for r in recordings)
    rests = [rows for rows in others if rows.shape[1] > LONG]
    hidden = all(np.all(np.ptp(rows, axis=1) == 0.0) for rows in rests) if rests else bool(recordings[0].declared.taxel_positions_mm)
    return hidden and level <= least_step(recordings, i)


def _at_rest(recording) -> np.ndarray:
    """Mask (N,) of the samples with next to no load."""
    load = _load(recording)
    load = np.zeros(len(recording)) if load is None else np.abs(load)
    return load <= GONE * load.max()


def apart(recordings: list) -> list[str]:
    """Names of taxels that follow the load in no session and are promised no reading: they may be open, or lie too far from the contact."""
    n = len(recordings[0].taxels)
    loads = [_load(r) for r in recordings]
    if n == 1 or any(load is None for load in loads):
        return []
    silent = [i for i in range(n) if _follows(loads, [r.taxels[i] for r in recordings]) < FOLLOWS]
    return [f"taxel_{i}" for i in silent if not promised(recordings, i, n)]


def _follows(loads: list[np.ndarray], rows: list[np.ndarray]) -> float:
    """Correlation with the load, by magnitude, in the session in which it is greatest."""
    return max(abs(_correlation(load, row)) for load, row in zip(loads, rows, strict=True))


def _loose(recordings: list, i: int, n: int) -> list[Symptom]:
    """A taxel that falls silent and comes back again and again."""
    name, loads = f"taxel_{i}", [_load(r) for r in recordings]
    if any(load is None for load in loads):
        return []
    by_depth = any(r.force is None for r in recordings)
    step = max(r.step(name) or 0.0 for r in recordings)
    found = contact_of([r.taxels[i] for r in recordings], loads, recordings[0].dt, by_depth, step)
    if found is None:
        return []
    bad = {(r.name, name): m for r, m in zip(recordings, found.lost, strict=True) if m.any()}
    share = float(np.mean(np.concatenate(found.lost)))
    since = next(r.t[np.argmax(m)] for r, m in zip(recordings, found.lost, strict=True) if m.any())
    jumps = f"{name} jumps {found.jumps} times between following the load and {found.level:.3g} N, without a jump of the load"
    where = in_sessions({r for r, _ in bad}, [r.name for r in recordings])
    beside = f", {where['pattern']}" if where else ""
    why = f"{jumps}; it is silent in {100 * share:.0f} % of the samples{beside}"
    return [_symptom(name, n, since, why, "intermittent", found.level, bad, where)]


def _dying(recordings: list, i: int, n: int) -> list[Symptom]:
    """A taxel that follows the load at first and not at all from some time to the end of the session. In other sessions it may be dead
    throughout."""
    name, bad, when = f"taxel_{i}", {}, []
    for r in recordings:
        start = _death(r, r.taxels[i])
        if start is not None:
            bad[r.name, name] = np.arange(len(r)) >= start
            when.append(r.t[0] + start * r.dt)
    if not bad:
        return _standing(recordings, i, n)
    lived = [(r, _usual(r, i)) for r in recordings if (r.name, name) in bad]
    rest = [r for r in recordings if (r.name, name) not in bad]
    still = [r for r in rest if np.ptp(r.taxels[i]) == 0.0 and any(_would_move(r, i, other, usual) for other, usual in lived)]
    bad |= {(r.name, name): np.ones(len(r), bool) for r in rest if r in still or _is_open(r, i, lived)}
    where = _silent_since(name, recordings, bad)
    follows = f"{name} follows the load {_while_it_lived(where['dead_from_s'])}"
    return [_symptom(name, n, when[0], follows, "dies", 0.0, bad, where)]


def _silent_since(name: str, recordings: list, bad: dict) -> dict:
    """Evidence of a finding: in which sessions the taxel is silent, and from what time on in each, s; 0 where throughout."""
    masks = {r.name: (r.t, mask) for r in recordings if (mask := bad.get((r.name, name))) is not None}
    since = {session: 0.0 if mask[0] else float(t[np.argmax(mask)]) for session, (t, mask) in masks.items()}
    return {"dead_from_s": since, **in_sessions(since, [r.name for r in recordings])}


def _while_it_lived(since: dict[str, float]) -> str:
    """The sentence's end, session by session: up to when the taxel followed the load, and where it never did."""
    dying = listed([f"up to {s:.1f} s of {session}" for session, s in since.items() if s != 0.0])
    dead = listed([session for session, s in since.items() if s == 0.0])
    return f"{dying} and not at all from there to the end{f', nor anywhere in {dead}' if dead else ''}"


def _standing(recordings: list, i: int, n: int) -> list[Symptom]:
    """A taxel that follows the load in some sessions, and holds one reading, or reads noise alone, throughout others that press as hard at
    the same place."""
    name = f"taxel_{i}"
    living = [(r, usual) for r in recordings if (usual := _usual(r, i)) > 0.0]
    still = [r for r in recordings if np.ptp(r.taxels[i]) == 0.0]
    dead = [r for r in still if any(_would_move(r, i, other, usual) and _felt_alike(r, other, i) for other, usual in living)]
    if not dead and len(recordings[0].taxels) > 1:  # other taxels show where the plunger pressed
        dead = [r for r in recordings if _is_open(r, i, [(other, usual) for other, usual in living if other is not r])]
    if not dead:
        return []
    level = float(np.median(dead[0].taxels[i]))
    bad = {(r.name, name): np.ones(len(r), bool) for r in dead}
    fades = {r.name: _fading(r, i, usual) for r, usual in living if r.taxels[i][-1] == level}
    bad |= {(r.name, name): np.arange(len(r)) >= fades[r.name] for r, _ in living if r.name in fades}
    reads = "holds" if np.ptp(dead[0].taxels[i]) == 0.0 else "reads noise about"
    press = f"which press{'es' * (len(dead) == 1)} as hard at the same place"
    elsewhere = f"{reads} {level:.3g} N throughout {listed([r.name for r in dead])}, {press}"
    since = min((r.t[0] + fades[r.name] * r.dt for r, _ in living if r.name in fades), default=0.0)
    where = _silent_since(name, recordings, bad)
    return [_symptom(name, n, since, f"{name} follows the load in {living[0][0].name}, and {elsewhere}", "dies", level, bad, where)]


def _is_open(recording, i: int, living: list) -> bool:
    """Whether a taxel reads noise alone though, by its usual slope in some `living` session, it should have moved."""
    load, row = _load(recording), recording.taxels[i]
    if load is None or abs(_correlation(load, row)) >= FOLLOWS:
        return False
    followed = [(other, usual) for other, usual in living if abs(_correlation(_load(other), other.taxels[i])) > FOLLOWED]
    moved = [usual for other, usual in followed if _would_move(recording, i, other, usual) and _felt_alike(recording, other, i)]
    return any(abs(_slope(load, row)) <= GONE * usual and usual * np.std(load) > PROMISED * np.std(row) for usual in moved)


def _usual(recording, i: int) -> float:
    """The steepest slope of a taxel against the load in a piece of the session where it surely follows; 0 where it follows in none."""
    load = _load(recording)
    return 0.0 if load is None else _Pieces(load, recording.taxels[i]).usual()


def _would_move(recording, i: int, other, usual: float) -> bool:
    """Whether a taxel with the `usual` slope, taken from the `other` session at the same declared place, would have left its reading in
    this one."""
    load, declared = _load(recording), recording.declared
    if load is None or tuple(declared.contact_of(recording.name)) != tuple(other.declared.contact_of(other.name)):
        return False
    return usual * float(np.std(load)) > PROMISED * max(other.step(f"taxel_{i}") or 0.0, 1e-12)


def _felt_alike(recording, other, i: int) -> bool:
    """Whether all other taxels have similar slopes in two sessions. If not, the sessions may press at different places that nobody
    declared."""
    pairs = [[_usual(r, j) for r in (recording, other)] for j in range(len(recording.taxels)) if j != i]
    return all(min(pair) >= ALIKE * max(pair) for pair in pairs) and (not pairs or np.max(pairs) > 0.0)


def _fading(recording, i: int, usual: float) -> int:
    """The sample from which on a taxel's slope no longer reaches the usual one."""
    of = _Pieces(_load(recording), recording.taxels[i])
    whole = np.flatnonzero(of.slopes > WHOLE * usual)
    return int(of.pieces[whole[-1]][-1]) + 1 if whole.size else 0


def _death(recording, row: np.ndarray) -> int | None:
    """The sample from which on the taxel no longer responds, or None."""
    load = _load(recording)
    if load is None:
        return None
    of = _Pieces(load, row)
    tested = np.flatnonzero([np.std(load[p]) > MOVED * np.std(load) for p in of.pieces])
    usual = of.usual(tested) or of.faintly(tested)
    alive = tested[of.slopes[tested] > ALIVE * usual]
    last = int(alive[-1]) if alive.size else -1
    dead = tested[tested > last]
    if last < 0 or usual <= 0.0 or not dead.size or np.any(np.abs(of.slopes[dead[1:]]) > GONE * usual):
        return None
    start = _last_sign_of_life(row, load, of.pieces, last, int(dead[min(1, dead.size - 1)]))
    return start if dead.size >= FEWEST or _silent_under_load(load, row, np.arange(start, row.size), GONE * usual) else None


class _Pieces:
    """A session in `PIECES` pieces, and a taxel's slope against the load in each."""

    def __init__(self, load: np.ndarray, row: np.ndarray):
        self.load, self.row = load, row
        self.pieces = np.array_split(np.arange(row.size), PIECES)
        self.slopes = np.array([_slope(load[p], row[p]) for p in self.pieces])

    def usual(self, among=range(PIECES)) -> float:
        """The steepest slope among the given pieces in which the taxel surely follows the load; 0 where it follows in none."""
        sure = [k for k in among if _correlation(self.load[self.pieces[k]], self.row[self.pieces[k]]) > SURE]
        return float(np.max(self.slopes[sure], initial=0.0))

    def faintly(self, among: np.ndarray) -> float:
        """The median slope of the given pieces in which the taxel follows, of a taxel that surely follows in none; 0 where they are few."""
        follow = [k for k in among if _correlation(self.load[self.pieces[k]], self.row[self.pieces[k]]) > FAINTLY]
        return float(np.median(self.slopes[follow])) if len(follow) >= FEWEST else 0.0


def _silent_under_load(load: np.ndarray, row: np.ndarray, span: np.ndarray, slope: float) -> bool:
    """Whether the taxel's slope stays below `slope` over a long span of samples in which the load changes much, if only at a few
    moments."""
    long = span.size >= (FEWEST - 1) * row.size / PIECES
    return bool(long and np.std(load[span]) > MUCH * np.std(load) and abs(_slope(load[span], row[span])) <= slope)


def _last_sign_of_life(row: np.ndarray, load: np.ndarray, pieces: list, last: int, dead: int) -> int:
    """The change point by least squares: a line that follows the load before it, a constant after it."""
    a, b = int(pieces[last][0]), int(pieces[dead][0])
    # From the piece before the last live one on, or from the first piece where that is the live one.
    before = slice(a - pieces[last].size, b) if last else slice(0, int(pieces[last][-1]) + 1)
    slope = _slope(load[before], row[before])
    slope = max(slope, _slope(load[:a], row[:a]) if a > 10 else slope)
    silent = float(np.median(row[b:]))
    lived = slice(0, pieces[last][-1] + 1)
    offset = float(np.median(row[lived] - slope * load[lived]))
    live = (row[a:b] - slope * load[a:b] - offset) ** 2
    still = (row[a:b] - silent) ** 2
    return a + int(np.argmin(np.concatenate([[0.0], np.cumsum(live - still)])))


def _symptom(
    name: str, n: int, since: float, why: str, kind: str, level: float, bad: dict | None = None, where: dict | None = None
) -> Symptom:
    parameters = {"since": quantity(since, "s"), "lost": quantity(1.0, "1"), "level": quantity(level, "N")}
    evidence = {"why": why, "kind": kind, "stuck": kind == "stuck", **(where or {})}
    return Symptom("dead_taxel", sensor_of(name, n), (name,), parameters, evidence, bad or {})


def _load(recording) -> np.ndarray | None:
    """The load: the force without its part from moving mass in air, or else the depth below the surface. None where neither moves, so that
    nothing is asked of a taxel."""
    force, depth = recording.force, recording.depth
    loads = [_while_pressed(force, depth), None if depth is None else np.maximum(depth, 0.0)]
    return next((load for load in loads if load is not None and not is_still(load)), None)


def _while_pressed(force: np.ndarray | None, depth: np.ndarray | None) -> np.ndarray | None:
    """The force, replaced in air by its median there."""
    if force is None or depth is None or depth.min() > 0.0:
        return force
    air = depth <= 0.0
    return np.where(air, np.median(force[air]), force)


def _correlation(a: np.ndarray, b: np.ndarray) -> float:
    a, b = a - a.mean(), b - b.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 0.0 else 0.0


def _slope(load: np.ndarray, row: np.ndarray) -> float:
    load = load - load.mean()
    energy = float(load @ load)
    return float(load @ row) / energy if energy > 0.0 else 0.0
