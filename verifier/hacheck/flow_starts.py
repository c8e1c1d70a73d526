"""Where runs along flows start: boxes around all starts, and starts that are certainly admissible."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from typing import Any

from hacheck import bernstein
from hacheck.brackets import Brackets, brackets, rooted
from hacheck.expressions import Instant
from hacheck.formula import members, placed, variables
from hacheck.polynomial import Env, const, names
from hacheck.rational import Beyond, Interval, Refused, number
from hacheck.records import Ends, Record
from hacheck.scope import Scope
from hacheck.tapes import Tape, holds, places

Json = Any


class FlowStarts:
    """The starts of an automaton, in the arithmetic of a record."""

    def __init__(self, scope: Scope, record: Record) -> None:
        self.scope, self.record = scope, record

    def mode(self, line: Json) -> str:
        """The mode that an init line names."""
        if line["mode"] is None and len(self.scope.modes) != 1:
            raise Beyond("flows that start in any mode")
        return next(iter(self.scope.modes)) if line["mode"] is None else str(line["mode"])

    def window(self) -> list[Json]:
        """The declared ranges of the variables, as conditions."""
        return [[op, ["var", v["name"]], e] for v in self.scope.automaton["vars"]
                for op, e in zip((">=", "<="), self.scope.window(v), strict=True) if e is not None]  # fmt: skip

    def admissible(self, start: Json) -> dict[str, Ends]:
        """Bounds of the values of a start that is certainly admissible (S5), or of one that is, in brackets."""
        scope, mode = self.scope, str(start["mode"])
        if set(start["values"]) != set(scope.types) or set(start["params"]) != set(scope.ranges):
            raise Refused("a start does not give every param and variable a value")
        roots = brackets(start["values"], scope.types)
        point = {v: number(q) for v, q in {**start["values"], **start["params"]}.items() if v not in roots}
        ranges = [[op, ["param", p], line[end]] for p, line in scope.ranges.items()
                  for op, end in ((">=", "low"), ("<=", "high"))]  # fmt: skip
        held = [self._sure(e, mode, point, roots) for e in [*ranges, *self.window()]]
        held.append(self._sure(scope.modes[mode]["domain"], mode, point, roots, True))
        lines = [["and", line["where"], *assigned(line)] for line in scope.automaton["init"] if self.mode(line) == mode]
        sure = self._rooted if roots else self._sure
        if not all(held) or not any(sure(line, mode, point, roots) for line in lines):
            raise Beyond("a start is not certainly admissible")
        return {**{v: (q, q) for v, q in point.items()}, **roots}

    def _rooted(self, e: Json, mode: str, point: Mapping[str, Fraction], roots: Brackets) -> bool:
        """Is a condition certainly true for some values in the brackets that are zeros of its equations?"""
        rest = rooted(placed(self.scope.identity(mode).condition(e), self._here(point)), roots)
        return rest is not None and bernstein.shown(rest, {**self.scope.box, **roots})

    def _here(self, point: Mapping[str, Fraction]) -> Env:
        return Env({**{v: const(q) for v, q in point.items()}, "time": const(0), "@sigma": const(0)})

    def _sure(self, e: Json, mode: str, point: Mapping[str, Fraction], roots: Brackets, closed: bool = False) -> bool:
        """Is a condition certainly true at a point? Exactly where it is one on polynomials, else as enclosures tell."""
        if isinstance(e, list) and e[:1] == ["and"]:
            return all(self._sure(f, mode, point, roots, closed) for f in e[1:])
        try:
            f = self.scope.identity(mode).condition(e, closed=closed)
            return bernstein.shown(placed(f, self._here(point)), {**self.scope.box, **roots})
        except Beyond:
            if roots:
                raise
            space, tape = self.record.space, Tape(self.scope, mode)
            truth = tape.truth(e, closed=closed)
            env = {v: space.number(q) for v, q in {**point, "time": Fraction(0)}.items()}
            return holds(truth, tape.values(places(truth), env, space)) is True

    def box(self, line: Json, mode: str, given: Json) -> dict[str, Ends]:
        """The box that a record gives for an init line, which must hold all its starts."""
        ends = {v: (number(low), number(high)) for v, (low, high) in given.items()}
        starts = self._starts(line, mode)
        for v, (low, high) in starts.items():
            if v in ends and not (ends[v][0] <= low and high <= ends[v][1]):
                raise Beyond(f"a recorded flow does not start everywhere: {v}")
        return {**starts, **ends}

    def _starts(self, line: Json, mode: str) -> dict[str, Ends]:
        """Bounds of all starts: those of single variables in the line and the domain, else the declared ranges."""
        at, found = self.scope.identity(mode), dict.fromkeys(self.scope.types, bernstein.FREE)
        conditions = [(e, True) for e in conjuncts(self.scope.modes[mode]["domain"])]
        for e, closed in [*conditions, *((e, False) for e in [*conjuncts(line["where"]), *assigned(line)])]:
            for v, i in _single(at, e, closed):
                if v in found:
                    found[v] = bernstein.meet(found[v], i)
        out: dict[str, Ends] = {}
        for v in self.scope.automaton["vars"]:
            low, high = found[v["name"]]
            wide = [self.scope.range(e) for e in self.scope.window(v)]
            low, high = wide[0][0] if low is None else low, wide[1][1] if high is None else high
            if low is None or high is None:
                raise Beyond(f"a start leaves {v['name']} without a bound")
            out[v["name"]] = low, high
        for p in self.scope.ranges:
            low, high = self.scope.box[p]
            assert low is not None and high is not None
            out[p] = low, high
        return out


def conjuncts(e: Json) -> Iterator[Json]:
    """The conjuncts of a condition."""
    if isinstance(e, list) and e[:1] == ["and"]:
        for f in e[1:]:
            yield from conjuncts(f)
    else:
        yield e


def assigned(line: Json) -> list[Json]:
    """What `with` says of an init line, as conditions."""
    signs = (("to", "=="), ("low", ">="), ("high", "<="))
    return [[op, ["var", r["var"]], r[end]] for r in line["with"] for end, op in signs if end in r]


def _single(at: Instant, e: Json, closed: bool) -> Iterator[tuple[str, Interval]]:
    """The bounds that a condition puts on single variables; what is not understood bounds nothing."""
    try:
        f = at.condition(e, closed=closed)
    except Beyond:
        return
    for g in members(f, "and"):
        if isinstance(g, bool) or g[0] not in ("<", "<=", "==") or len(variables(g)) != 1:
            continue
        (v,), p = names(g[1]), g[1]
        if p.terms.keys() <= {(v,), ()}:
            a, end = p.terms[v,], Fraction(-p.terms.get((), 0), p.terms[v,])
            yield v, (end if a < 0 or g[0] == "==" else None, end if a > 0 or g[0] == "==" else None)
