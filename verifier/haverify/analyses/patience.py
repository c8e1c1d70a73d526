"""The time that a claim may take: what decides verdicts is work, this is the net below it.

A thread looks at the clock. When the time is over it has the main thread raise `OutOfTimeError`, and the kernel give up
what it follows. Some libraries drop what is raised within them, so it is raised again if the work goes on.
"""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from haverify.solvers.kernel import halt

_LOOK = 0.2  # s between two looks at the clock
_AGAIN = 5.0  # s of CPU time that giving up may take
_SIGNAL = signal.SIGALRM


class OutOfTimeError(Exception):
    """The time allowed is over."""


@contextmanager
def allowed(seconds: float) -> Iterator[None]:
    """Raise `OutOfTimeError` in what takes more CPU time, all threads of the process together.

    Within another allowance that one holds; there is none outside of the main thread, which alone can be interrupted.
    """
    is_inner = signal.getsignal(_SIGNAL) is _give_up
    if is_inner or threading.current_thread() is not threading.main_thread():
        yield
        return
    over = threading.Event()
    watch = threading.Thread(target=_watch, args=(time.process_time() + seconds, over), daemon=True)
    before = signal.signal(_SIGNAL, _give_up)
    try:
        watch.start()
        yield
    finally:
        signal.signal(_SIGNAL, signal.SIG_IGN)
        over.set()
        watch.join()
        halt(False)
        signal.signal(_SIGNAL, before or signal.SIG_DFL)


def _watch(end: float, over: threading.Event) -> None:
    while not over.wait(_LOOK):
        if time.process_time() >= end:
            end = time.process_time() + _AGAIN
            signal.pthread_kill(threading.main_thread().ident or 0, _SIGNAL)
            halt(True)


def _give_up(*_: Any) -> None:
    raise OutOfTimeError
