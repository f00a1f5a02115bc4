"""How old feedback is when a client hears it, and how soon the plunger answers a cancel or too great a force.

    bench_feedback.py [--trials 10]        (./skin bench feedback: as it stands)

A ramp of 0.5 mm/s on the simulated rig in real time, driver, server and client in a process each. Feedback carries a depth, and on a ramp
every depth belongs to one sample: its age is the time from that sample's stamp to the arrival of the feedback. The answer to a cancel
(from the client's call) or to the first sample above `max_force` (from its stamp) is the first sample that lies 5 um short of the ramp.
"""

import argparse
import time

import numpy as np
from session import Session

BACK = "{type: straight_line, to_mm: -0.2, speed_mm_s: 5}"
RAMP = "{type: straight_line, to_mm: 1.5, speed_mm_s: 0.5}"
SHORT = 5e-6  # m


def ages(session: Session) -> np.ndarray:
    """Age (s) of every feedback that came while the plunger moved."""
    stamps = {round(1e6 * x): t for t, x in reversed(session.encoder)}
    found = [(came, stamps.get(round(1e6 * f.depth))) for came, f in session.feedback if f.segment != "stop" and -1e-4 < f.depth < 1.4e-3]
    return np.array([came - stamp for came, stamp in found if stamp is not None])


def departure(encoder: np.ndarray, since: float) -> float:
    """Seconds from `since` to the first sample that is short of the ramp, which is the line through the samples before."""
    t, x = encoder.T
    before = (t > since - 0.5) & (t < since)
    line = np.polynomial.Polynomial.fit(t[before], x[before], 1)
    return float(t[(t > since) & (line(t) - x > SHORT)][0] - since)


def cancelled(session: Session) -> tuple[float, np.ndarray]:
    """One ramp, cancelled half-way: time to the answer, and the ages of its feedback."""
    session.execute(BACK)
    goal = session.begin(RAMP)
    session.until(lambda: session.encoder[-1][1] > 6e-4, "the ramp")
    now = time.time()
    session.cancel(goal)
    return departure(np.array(session.encoder), now), ages(session)


def too_much(session: Session) -> float:
    """One ramp that ends by its own limit of force: time to the answer."""
    session.execute(BACK)
    _, encoder, force = session.execute(RAMP, max_force=6.0)
    return departure(encoder, force[np.argmax(force[:, 1] > 6.0), 0])


def main() -> None:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--trials", type=int, default=10)
    trials = parser.parse_args().trials
    with Session(driver={"sample_rate": 100.0}) as session:
        stops, old = zip(*(cancelled(session) for _ in range(trials)), strict=True)
        forces = [too_much(session) for _ in range(trials)]
    for name, values in (("age of feedback", np.concatenate(old)), ("cancel to brake", stops), ("over-force to brake", forces)):
        low, half, most = 1e3 * np.percentile(values, (0, 50, 100))
        print(f"{name:22}{len(values):5d} times{half:8.1f} ms (median){low:8.1f} to{most:8.1f}", flush=True)


if __name__ == "__main__":
    main()
