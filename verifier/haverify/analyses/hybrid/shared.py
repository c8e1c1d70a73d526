"""Trees of stretches that claims share: each is grown once, and judged for every claim that asks for it."""

from __future__ import annotations

import os
from collections.abc import Callable, Hashable, Sequence
from threading import Thread
from typing import Any, TypeVar

from haverify.analyses.hybrid.expansion import Expanded
from haverify.model.hybrid import HybridAutomaton
from haverify.solvers.kernel import Listing, Tree
from haverify.text.record import field, holder

MOST = 12_000_000  # floats of polynomials that are kept
THREADS = min(4, os.cpu_count() or 1)  # in which trees are grown at the same time

T = TypeVar("T")


@holder
class Trees:
    """Trees by what they enclose: the oldest are let go where they need too much memory."""

    known: dict[Hashable, Tree] = field(default_factory=dict)
    size: int = 0
    # What is recorded of them, for all claims that rest on the same.
    files: dict[Hashable, Any] = field(default_factory=dict)
    # The fields of the model, compiled.
    compiled: dict[Hashable, Listing] = field(default_factory=dict)

    # Trees that were grown for a question which has not looked at them yet.
    fresh: set[Hashable] = field(default_factory=set)
    # The modes to which runs came, where not all modes of a system are listed.
    seen: set[str] = field(default_factory=set)
    # Automata written out, beside what they were.
    _written: list[tuple[HybridAutomaton, Expanded]] = field(default_factory=list)

    def written(self, automaton: HybridAutomaton, write: Callable[[], Expanded]) -> Expanded:
        """The automaton written out, once for all claims."""
        found = next((made for given, made in self._written if given is automaton), None)
        if found is None:
            found = write()
            self._written.append((automaton, found))
        return found

    def get(self, key: Hashable, grow: Callable[[], Tree]) -> tuple[Tree, bool]:
        """The tree, and whether it was grown just now."""
        if key in self.known:
            is_new = key in self.fresh
            self.fresh.discard(key)
            return self.known[key], is_new
        tree = grow()
        self._keep(key, tree)
        return tree, True

    def grow(self, wanted: Sequence[tuple[Hashable, Callable[[], Tree]]]) -> None:
        """Grow those of some trees that are missing, each in a thread of its own.

        What a tree is does not depend on others, and they are kept in the order given: how many threads there are
        makes no difference.
        """
        missing = {key: grow for key, grow in wanted if key not in self.known}
        for key, tree in zip(missing, at_once(list(missing.values())), strict=True):
            self._keep(key, tree)
            self.fresh.add(key)

    def _keep(self, key: Hashable, tree: Tree) -> None:
        self.size += tree.size()
        self.known[key] = tree
        while self.size > MOST and len(self.known) > 1:
            self.size -= self.known.pop(next(iter(self.known))).size()


def at_once(calls: Sequence[Callable[[], T]]) -> list[T]:
    """What some calls return, each made in a thread of its own; the first of their exceptions, if there is one."""
    if len(calls) == 1:
        return [calls[0]()]
    results: list[list[T]] = [[] for _ in calls]
    faults: list[list[Exception]] = [[] for _ in calls]

    def made(number: int) -> None:
        try:
            results[number].append(calls[number]())
        except Exception as e:  # noqa: BLE001 (raised again below, in the thread that asked)
            faults[number].append(e)

    threads = [Thread(target=made, args=(number,)) for number in range(len(calls))]
    for thread in threads:
        thread.start()
    _joined(threads)
    for fault in (f for found in faults for f in found):
        raise fault
    return [result for found in results for result in found]


def _joined(threads: Sequence[Thread]) -> None:
    """Wait for all of some threads, also where the wait for one is interrupted."""
    if threads:
        try:
            threads[0].join()
        finally:
            _joined(threads[1:])
