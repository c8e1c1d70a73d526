"""Trees of stretches that claims share: each is grown once, and judged for every claim that asks for it."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any

from haverify.solvers.kernel import Tree
from haverify.text.record import field, holder

MOST = 12_000_000  # floats of polynomials that are kept


@holder
class Trees:
    """Trees by what they enclose: the oldest are let go where they need too much memory."""

    known: dict[Hashable, Tree] = field(default_factory=dict)
    size: int = 0
    # What is recorded of them, for all claims that rest on the same.
    files: dict[Hashable, Any] = field(default_factory=dict)

    def get(self, key: Hashable, grow: Callable[[], Tree]) -> tuple[Tree, bool]:
        """The tree, and whether it was grown just now."""
        if key in self.known:
            return self.known[key], False
        tree = grow()
        self.size += tree.size()
        self.known[key] = tree
        while self.size > MOST and len(self.known) > 1:
            self.size -= self.known.pop(next(iter(self.known))).size()
        return tree, True
