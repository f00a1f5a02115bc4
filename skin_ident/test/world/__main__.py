"""python -m world --cause stress_relaxation --size 1 --seed 3 --out DIR"""

import argparse
import json
from pathlib import Path

from . import PLACES, make_sessions, write_case
from .protocols import BODIES


def main():
    parser = argparse.ArgumentParser("world", description="Make recordings that hide an effect.")
    parser.add_argument("--cause", default="null", choices=["null", *PLACES])
    parser.add_argument("--where")
    parser.add_argument("--form")
    parser.add_argument("--size", type=float, default=1.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--protocol", default="full", choices=BODIES)
    parser.add_argument("--sessions", type=int, default=3)
    parser.add_argument("--taxels", type=int, default=1)
    parser.add_argument("--noise", default="any")
    parser.add_argument("--out", required=True, type=Path)
    o = parser.parse_args()
    sessions, truth = make_sessions(o.cause, o.where, o.form, o.size, o.seed, o.protocol, o.sessions, o.taxels, o.noise)
    write_case(sessions, o.out)
    print(json.dumps([{k: v for k, v in vars(h).items() if k != "effect"} for h in truth.hidden], indent=1))
    print(f"{len(sessions)} sessions of {sessions[0].t.size} samples in {o.out}; noise {truth.noise}")


if __name__ == "__main__":
    main()
