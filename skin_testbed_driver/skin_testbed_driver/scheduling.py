"""What a process asks of Linux in order to wake on time. Elsewhere, and where it is refused, nothing happens."""

import contextlib
import ctypes
import os
import platform
import struct
import sys
import threading

_SCHED_SETATTR = {"x86_64": 314, "aarch64": 274, "riscv64": 274}  # the numbers of the system call; Python has no function for it
_ATTR = struct.Struct("=IIQiIQQQ")  # struct sched_attr: size, policy, flags, nice, priority, runtime, deadline, period
_SLICE = 100_000  # ns, the shortest that the scheduler grants


def be_punctual() -> None:
    """Let every thread of the process wake without slack (by default Linux rounds up by 50 us), and before others that have long turns.

    The second is done by a short slice of the fair scheduler, from Linux 6.12 on: no more time than before, but sooner (sched(7), EEVDF).
    It is done for all threads, because one that has to wait while it holds the interpreter or a lock of DDS keeps the others waiting.
    """
    if not sys.platform.startswith("linux"):
        return
    for task in _tasks():
        with contextlib.suppress(OSError):  # refused, or the thread has just ended
            with open(f"/proc/{task}/timerslack_ns", "w") as file:  # noqa: PTH123  (a file of the kernel)
                file.write("1")
            _shorten_turns(task)


def _shorten_turns(task: int) -> None:
    """Only under the fair scheduler, and at the niceness that the task has: `chrt` and `nice` are the user's."""
    call = _SCHED_SETATTR.get(platform.machine())
    if call and os.sched_getscheduler(task) == os.SCHED_OTHER:
        attributes = _ATTR.pack(_ATTR.size, os.SCHED_OTHER, 0, os.getpriority(os.PRIO_PROCESS, task), 0, _SLICE, 0, 0)
        ctypes.CDLL(None).syscall(call, task, attributes, 0)  # an older kernel ignores the slice


def _tasks() -> list[int]:
    try:
        return [int(task) for task in os.listdir("/proc/self/task")]  # noqa: PTH208
    except OSError:
        return [threading.get_native_id()]


def be_urgent(priority: int) -> None:
    """Real-time scheduling (SCHED_FIFO) at `priority` for the calling thread, and at one less for all others. Raises `OSError`.

    The others need it too: one that is preempted while it holds the interpreter or a lock of DDS would keep the caller waiting.
    """
    for task in _tasks():
        mine = task == threading.get_native_id()
        os.sched_setscheduler(task, os.SCHED_FIFO, os.sched_param(priority if mine else max(priority - 1, 1)))
