"""The generated tables of the grammar as the parser uses them, loaded once."""

from __future__ import annotations

import json
import re
from functools import cache
from pathlib import Path
from typing import Any

from haverify.text.record import record


@record
class Rule:
    """A production: how many symbols it takes, and which children its node gets.

    `passes` productions stand for their only symbol. `plan` is None when every symbol is a child; else it lists
    (place, splice, absent before), and last the absent children at the end.
    """

    origin: str
    callback: str
    size: int
    passes: bool
    single: bool
    spliced: bool
    plan: tuple[tuple[int, int, int], ...] | None


class Rules(dict[int, Rule]):
    """The productions by their number in `states`, which is negative; a file makes use of some."""

    def __init__(self, rows: list[Any]) -> None:
        super().__init__()
        self._rows = rows

    def __missing__(self, number: int) -> Rule:
        found = self[number] = _rule(self._rows[-1 - number])
        return found


@record
class Language:
    """`states[state][symbol]` is the next state, or when negative the number in `rules` of the rule to reduce by.

    `starters` are the reserved words that begin a declaration, a member or a line of some block.
    """

    states: list[dict[str, int]]
    rules: Rules
    words: dict[str, str]
    symbols: dict[str, str]
    reserved: frozenset[str]
    scanner: re.Pattern[str]
    unit: re.Pattern[str]
    number: re.Pattern[str]
    starters: frozenset[str]

    def spelling(self, terminal: str) -> str:
        """What an author writes for a terminal that is one word or symbol; empty for the others."""
        found = [text for table in (self.words, self.symbols) for text, name in table.items() if name == terminal]
        return found[0] if len(found) == 1 else ""


def _rule(row: list[Any]) -> Rule:
    origin, callback, size, steps, single = row
    plan = tuple((place, splice, absent) for place, splice, absent in steps)
    identical = plan == (*((k, 0, 0) for k in range(size)), (-1, 0, 0))
    spliced = origin.startswith("_")
    passes = size == 1 and single and identical
    return Rule(origin, callback, size, passes, single, spliced, None if identical else plan)


@cache
def language() -> Language:
    """The language of grammar.lark, from tables.json."""
    data = json.loads(Path(__file__).with_name("tables.json").read_text(encoding="utf-8"))
    return Language(
        data["states"],
        Rules(data["rules"]),
        data["words"],
        data["symbols"],
        frozenset(data["reserved"]),
        re.compile(data["scanner"], re.DOTALL),
        re.compile(data["unit"]),
        re.compile(data["number"]),
        frozenset(data["starters"]),
    )
