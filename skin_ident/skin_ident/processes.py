"""Worker processes that ignore Ctrl-C, which a terminal sends to a whole process group, and that end when their parent process does."""

import os
import signal
import threading
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import active_children, get_context, parent_process

THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")


@contextmanager
def workers(jobs: int | None = None, *, finish: bool) -> Iterator[ProcessPoolExecutor]:
    """A pool of worker processes; submit to it within `no_interrupts`. When an exception leaves the block, tasks that have begun are
    finished if `finish` is True, else terminated; tasks that have not begun are dropped."""
    for name in THREADS:  # one thread each: the processes are the parallelism
        os.environ.setdefault(name, "1")
    before = active_children()
    pool = ProcessPoolExecutor(jobs or os.cpu_count(), mp_context=get_context("spawn"), initializer=_end_with_parent)
    try:
        yield pool
    except BaseException:
        if not finish:
            for process in set(active_children()) - set(before):
                process.terminate()
        raise
    finally:  # interrupted: what has not begun is dropped
        pool.shutdown(cancel_futures=True)


@contextmanager
def no_interrupts() -> Iterator[None]:
    """Block Ctrl-C during the block. Processes that are started in it never receive it."""
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _end_with_parent() -> None:
    """Let this process end when its parent is killed; otherwise it would wait for work for ever."""

    def wait() -> None:
        parent_process().join()
        os._exit(1)

    threading.Thread(target=wait, daemon=True).start()
