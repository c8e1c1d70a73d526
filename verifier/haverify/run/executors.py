"""Ways to have claims decided: one after the other, or by processes that share the claims."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from haverify.evidence.evidence import Evidence
from haverify.model.spec import Spec
from haverify.text.record import field, holder

_USUAL = Fraction(60)  # the budget, in s, that stands for the usual amount of work: limits are work, not time


@holder
class Solved:
    """Proposed evidence by claim. A claim without any was not reached, or made an analysis fail (`faults`).

    `seconds` are wall and CPU time; claims decided together share theirs evenly.
    """

    evidence: dict[str, Evidence] = field(default_factory=dict)
    seconds: dict[str, tuple[float, float]] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)
    is_interrupted: bool = False

    def and_then(self, later: Solved) -> Solved:
        """Both together."""
        return Solved(
            self.evidence | later.evidence,
            self.seconds | later.seconds,
            self.faults + later.faults,
            self.is_interrupted or later.is_interrupted,
        )


def solve(spec: Spec, names: Sequence[str], budget: Fraction, jobs: int, core: Any = None) -> Solved:
    """What the analyses propose for the named claims; the same for any number of jobs.

    An exception in an analysis costs its claims and is a fault; an interrupt keeps what is done.
    """
    if not names:
        return Solved()
    parts = list(_shares(spec, names, jobs))
    if jobs <= 1 or len(parts) == 1:
        return _one_by_one(spec, parts, budget, core)
    return _by_processes(spec, parts, budget, jobs)


def _shares(spec: Spec, names: Sequence[str], jobs: int) -> Iterator[list[str]]:
    """Claims about one automaton together, because they share its reached cells, in pieces of at most 16."""
    about: dict[str | None, list[str]] = {}
    on = {c.name: c.on for c in spec.claims}
    for name in names:
        about.setdefault(on[name], []).append(name)
    size = max(1, min(16, -(-len(names) // jobs)))
    for group in about.values():
        yield from (group[k : k + size] for k in range(0, len(group), size))


def _one_by_one(spec: Spec, parts: Sequence[list[str]], budget: Fraction, core: Any) -> Solved:
    solved = Solved()
    try:
        for part in parts:
            _add(solved, _share(spec, part, budget, core))
    except KeyboardInterrupt:
        solved.is_interrupted = True
    return solved


def _add(total: Solved, part: Solved) -> None:
    """Take in the answers of some claims."""
    total.evidence |= part.evidence
    total.seconds |= part.seconds
    total.faults += part.faults


def _share(spec: Spec, names: list[str], budget: Fraction, core: Any = None) -> Solved:
    """The evidence for some claims; when that fails, for each of them alone, so one failure costs one claim."""
    from haverify.analyses.portfolio import decide_all

    wall, cpu = time.perf_counter(), time.process_time()
    try:
        evidence = decide_all(spec, names, budget / _USUAL, core)
        each = (time.perf_counter() - wall) / len(names), (time.process_time() - cpu) / len(names)
        return Solved(evidence, dict.fromkeys(names, each))
    except Exception as e:  # noqa: BLE001 - whatever an analysis raises is our fault and exit code 4
        if len(names) > 1:
            alone = (_share(spec, [name], budget, core) for name in names)
            total = Solved()
            for one in alone:
                total = total.and_then(one)
            return total
        return Solved(faults=[f"{names[0]}: {_place(e)}"])


def _place(e: Exception) -> str:
    """The exception with its traceback: it goes into a bug report."""
    if not os.environ.get("HAVERIFY_DEBUG"):
        return repr(e)
    import traceback

    return "".join(traceback.format_exception(e)).rstrip()


_SPEC: list[Spec] = []


def _begin(spec: Spec) -> None:
    """Keep the spec in the worker, so that it is sent once."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent decides what an interrupt means
    _SPEC[:] = [spec]


def _in_worker(names: list[str], budget: Fraction) -> Solved:
    return _share(_SPEC[0], names, budget)


def _by_processes(spec: Spec, parts: Sequence[list[str]], budget: Fraction, jobs: int) -> Solved:
    """The shares mapped over worker processes; a worker that dies costs its claims, and is a fault."""
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    done: list[Solved] = []
    pool = ProcessPoolExecutor(min(jobs, len(parts)), initializer=_begin, initargs=(spec,))
    try:
        for part, future in [(part, pool.submit(_in_worker, part, budget)) for part in parts]:
            try:
                done.append(future.result())
            except BrokenProcessPool:
                done.append(Solved(faults=[f"{name}: a worker process died" for name in part]))
    except KeyboardInterrupt:
        done.append(Solved(is_interrupted=True))
    finally:
        pool.shutdown(wait=not any(d.is_interrupted for d in done), cancel_futures=True)
    total = Solved()
    for one in done:
        total = total.and_then(one)
    return total
