"""A flow with the derivatives of its solutions by their start: `Phi' = Df Phi`, as further variables of the flow."""

from __future__ import annotations

from typing import Any

from hacheck.enclosures import Space
from hacheck.rational import Beyond
from hacheck.records import Record
from hacheck.scope import Scope
from hacheck.tapes import Tape
from hacheck.tubes import Field

Json = Any
CORNERS = {"abs", "sign"}  # what has no second derivative


def derived(variable: str, by: str) -> str:
    """The name of a derivative; no variable has an apostrophe in its name."""
    return f"{variable}'{by}"


def all_names(plain: list[str], columns: list[str]) -> list[str]:
    """The variables, and a column of derivatives by each of some."""
    return [*plain, *(derived(v, c) for c in columns for v in plain)]


def smooth(tape: Tape, places: list[int]) -> None:
    """Raise Beyond where what some places hold has corners."""
    if any(tape.ops[i][0] in CORNERS for i in tape.used(tuple(places))):
        raise Beyond("a periodic orbit beside what has corners")


class Varied(Field):
    """The flow of a mode, and of derivatives by some variables of the start, derived here from the core."""

    def __init__(self, scope: Scope, mode: str, fine: Space, coarse: Space, columns: list[str]) -> None:
        super().__init__(scope, mode, fine, coarse)
        plain, jacobian = self.names, self.slopes
        for c in columns:
            column = [self.tape.put("name", derived(v, c)) for v in plain]
            self.rates += [self._along(row, column) for row in jacobian]
        self.names = all_names(plain, columns)
        self.slopes = [[self.tape.slope(r, v) for v in self.names] for r in self.rates]
        smooth(self.tape, [*self.rates, *(p for row in self.slopes for p in row if p is not None)])

    def _along(self, row: list[int | None], column: list[int]) -> int:
        terms = [self.tape.times(s, v) for s, v in zip(row, column, strict=True) if s is not None]
        out = terms[0] if terms else self.tape.put("number", 0)
        for t in terms[1:]:
            out = self.tape.put("+", out, t)
        return out


class VariedRecord(Record):
    """Recorded polynomials of states and of their derivatives by some variables of the start."""

    def __init__(self, scope: Scope, data: Json, columns: list[str]) -> None:
        self.columns = columns
        super().__init__(scope, data, all_names(list(scope.types), columns))
        if not set(self.set) <= set(scope.types):
            raise Beyond("a recorded lap varies derivatives")

    def field(self, mode: str) -> Varied:
        """The flow of a mode with derivatives."""
        if mode not in self._fields:
            self._fields[mode] = Varied(self.scope, mode, self.space, self.coarse, self.columns)
        found = self._fields[mode]
        assert isinstance(found, Varied)
        return found
