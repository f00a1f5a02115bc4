"""How every installed command starts: Ctrl-C ends it with one word and status 130, also while it is still importing.

Linear algebra keeps to one thread, unless OPENBLAS_NUM_THREADS says otherwise: the matrices here are too thin for more, and where other
processes occupy the cores its threads only wait for each other, which made fits twenty times slower.

A package lists its commands in `executables.py`, which imports nothing heavy, and setup.py points there: an interruption in the seconds
that the import of scipy or rclpy takes would otherwise print a traceback from inside them.
"""

import contextlib
import importlib
import os
import signal
import sys
from collections.abc import Callable, Iterator

INTERRUPTED = 130


def command(module: str) -> Callable[[], int | None]:
    """What a console script calls: `main()` of `module`, which is imported only then."""

    def main() -> int | None:
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when numpy is imported
        with _leaving_at_once():
            entry = importlib.import_module(module).main
        try:
            return entry()
        except KeyboardInterrupt:  # a command that has something to say about it, such as what is kept, does so itself
            print("interrupted", file=sys.stderr)
            return INTERRUPTED

    main.module = module
    return main


@contextlib.contextmanager
def _leaving_at_once() -> Iterator[None]:
    """Exit at once on Ctrl-C within the block: there is nothing to clean up yet, and an exception raised amid an import may be swallowed,
    or come out as another."""
    before = signal.getsignal(signal.SIGINT)
    if before is not signal.default_int_handler:  # a job in the background has Ctrl-C switched off
        yield
        return
    signal.signal(signal.SIGINT, _leave)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _leave(*_: object) -> None:
    os.write(2, b"interrupted\n")
    os._exit(INTERRUPTED)
