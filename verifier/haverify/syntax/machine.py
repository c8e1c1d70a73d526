"""The LALR machine: pieces of text in, tree nodes out, one table look-up per step."""

from __future__ import annotations

from typing import Any

from haverify.syntax.build import Builder
from haverify.syntax.language import Language, Rule


class Machine:
    """A stack of states with the value and the text range of the symbol that led to each."""

    def __init__(self, language: Language, builder: Builder) -> None:
        self.table = language.states
        self.rules = language.rules
        self.states = [0]
        self.values: list[Any] = [None]
        self.starts = [0]
        self.ends = [0]
        self._builder = builder

    def feed(self, symbol: str, value: Any, start: int, end: int) -> bool:
        """Take one symbol; False, with the reductions before it made, when it cannot stand here."""
        states, table, rules = self.states, self.table, self.rules
        while True:
            action = table[states[-1]].get(symbol)
            if action is None:
                return False
            if action >= 0:
                states.append(action)
                self.values.append(value)
                self.starts.append(start)
                self.ends.append(end)
                return True
            rule = rules[action]
            if rule.passes:
                states[-1] = table[states[-2]][rule.origin]
            else:
                self._reduce(rule)

    def after(self, states: list[int], symbol: str) -> int:
        """The state that `symbol` leads to from a stack (which is used up), -1 when it cannot stand there."""
        while True:
            action = self.table[states[-1]].get(symbol)
            if action is None:
                return -1
            if action >= 0:
                return action
            rule = self.rules[action]
            del states[-rule.size :]
            states.append(self.table[states[-1]][rule.origin])

    def accepts(self, symbol: str) -> bool:
        """Whether `symbol` can stand here."""
        return self.after(list(self.states), symbol) >= 0

    def drop(self, height: int) -> None:
        """Forget everything above the lowest `height` states."""
        for stack in (self.states, self.values, self.starts, self.ends):
            del stack[height:]

    def _reduce(self, rule: Rule) -> None:
        size = rule.size
        children = self.values[-size:]
        start, end = self.starts[-size], self.ends[-1]
        del self.states[-size:], self.values[-size:], self.starts[-size:], self.ends[-size:]
        if rule.plan is not None:
            children = _selected(children, rule)
        self.states.append(self.table[self.states[-1]][rule.origin])
        if rule.spliced:
            self.values.append(children)
        elif rule.single and len(children) == 1:
            self.values.append(children[0])
        else:  # every such rule of the grammar has a builder, which a test checks
            self.values.append(getattr(self._builder, rule.callback)(children, start, end))
        self.starts.append(start)
        self.ends.append(end)


def _selected(children: list[Any], rule: Rule) -> list[Any]:
    assert rule.plan is not None
    *steps, (_, _, absent) = rule.plan
    chosen: list[Any] = []
    for place, splice, before in steps:
        if before:
            chosen.extend([None] * before)
        if splice:
            if not chosen:
                chosen = children[place]  # the left part of a long list grows in place
            else:
                chosen.extend(children[place])
        else:
            chosen.append(children[place])
    if absent:
        chosen.extend([None] * absent)
    return chosen
