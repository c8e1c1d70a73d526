"""Claims about a flow, shown along recorded polynomials: one for each variable, step, and piece of the starts.

How far solutions are from the polynomials is found here (`tubes.py`); a record says nothing about it. A record that is
too coarse is beyond the checker, not refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from math import ceil, floor
from typing import TYPE_CHECKING, Any, NamedTuple

from hacheck import bernstein
from hacheck.enclosures import HIGHEST, Model, Space, Terms, degree, exponents, key, widened
from hacheck.expressions import Instant
from hacheck.formula import conj, members, placed, variables
from hacheck.polynomial import Env, const, names
from hacheck.rational import Beyond, Interval, Refused, number, spend
from hacheck.scope import Scope
from hacheck.tapes import holds, places
from hacheck.tubes import Field

if TYPE_CHECKING:
    from hacheck.obligations import Question, Shown

Json = Any
Ends = tuple[Fraction, Fraction]
GUARD, COARSE_TIME, CLOSE = 16, 4, 14
HALF = {-1: ((0, 1), (1, 1)), 0: ((-1, 1), (1, 1))}  # (a + b x) / 2 for the halves of [0, 1] and [-1, 1]


class Tube(NamedTuple):
    """All states of a step from `start` to `end`: a model for every variable, param and the time."""

    start: Fraction
    end: Fraction
    states: dict[str, Model]


class Record:
    """A file of recorded polynomials: what is common to all its steps."""

    def __init__(self, scope: Scope, mode: str, data: Json) -> None:
        if (data["schema"], data["automaton"]) != ("haverify.flow/1", scope.automaton["name"]):
            raise Refused("a recorded flow has another schema, or is of another automaton")
        self.scope, self.data, self.moving = scope, data, list(scope.types)
        self.shift, self.set = _whole(data["bits"], 8, 120), list(data["set"])
        if len(set(self.set)) < len(self.set) or not set(self.set) <= {*self.moving, *scope.ranges}:
            raise Refused("a recorded flow varies what is no variable or param")
        self.monomials = [self._monomial(m) for m in data["monomials"]]
        self.time = _whole(data["order"], 1, HIGHEST)
        most = max([degree(m) for m in self.monomials], default=0)
        if len(set(self.monomials)) < len(self.monomials):
            raise Refused("a recorded flow has a monomial twice")
        bits = self.shift + GUARD
        coarse = 2 if len(self.set) <= 3 else 1
        self.space = Space(bits, self.time, max(most, coarse))
        self.field = Field(scope, mode, self.space, Space(bits, min(COARSE_TIME, self.time), coarse))

    def _monomial(self, given: Json) -> int:
        if len(given) != len(self.set):
            raise Refused("a monomial of a recorded flow is of other variables")
        found = key(_whole(e, 0, HIGHEST) for e in given)
        if sum(given) > HIGHEST:
            raise Refused("a monomial of a recorded flow has too high a degree")
        return found

    def tubes(self, box: Mapping[str, Ends], steps: list[Json], until: Fraction) -> Iterator[Tube]:
        """What encloses all solutions from the box, step by step up to an instant."""
        start = {v: self._start(v, box[v]) for v in [*self.moving, *self.scope.ranges]}
        front = self.field.front({v: Model(start[v].parts, 0) for v in self.moving},
                                 [start[v].radius for v in self.moving])  # fmt: skip
        fixed, time, one = {p: start[p] for p in self.scope.ranges}, 0, self.space.one
        for step in steps:
            if time > until * one:
                return
            h = _whole(step["h"], 1, 10**18) << GUARD
            clock = Model({0: {0: time}, 1: {0: h}}, 0)
            paths = {v: self._path(front.centre[v], c) for v, c in zip(self.moving, step["x"], strict=True)}
            env = {**fixed, "time": clock, **paths}
            off, front = self.field.step(front, env, h)
            states = {**env, **{v: widened(env[v], r) for v, r in zip(self.moving, off, strict=True)}}
            yield Tube(Fraction(time, one), Fraction(time + h, one), states)
            time += h
        if time < until * one:
            raise Beyond("a recorded flow ends before the claim's horizon")

    def _start(self, name: str, ends: Ends) -> Model:
        """All values between two: along a set variable of its own, or as a number with an error."""
        one, (low, high) = self.space.one, ends
        least, most = floor(low * one), ceil(high * one)
        most += (most - least) & 1
        centre, half = (least + most) >> 1, (most - least) >> 1
        if name not in self.set:
            return Model({0: {0: centre}}, half)
        return Model({0: {0: centre, self.unit(self.set.index(name)): half}}, 0)

    def unit(self, variable: int) -> int:
        """The monomial that is one set variable."""
        return key([*[0] * variable, 1])

    def _path(self, start: Model, coefficients: Json) -> Model:
        """The polynomial that begins at `start` and has these coefficients of the powers of t, from the first."""
        parts: dict[int, Terms] = dict(start.parts)
        if len(coefficients) > self.time:
            raise Refused("a recorded flow has a power of t above its order")
        for i, row in enumerate(coefficients):
            if len(row) > len(self.monomials):
                raise Refused("a recorded flow has more coefficients than monomials")
            spend(1 + len(row))
            found = (_whole(c, -(10**18), 10**18) << GUARD for c in row)
            parts[i + 1] = {k: c for k, c in zip(self.monomials, found, strict=False) if c}
        return Model(parts, 0)


def _whole(n: Json, low: int, high: int) -> int:
    if type(n) is not int or not low <= n <= high:
        raise Refused("a recorded flow has a number that is none, or out of its range")
    return n


class Along:
    """One goal of a claim along a recorded flow."""

    def __init__(self, question: Question, name: Json) -> None:
        self.q, self.scope, self.model = question, question.scope, question.model
        self.mode = self._only_mode()
        if self.scope.rounding or question.assume or question.limit is None:
            raise Beyond("a flow with rounded constants, assumptions, or no horizon")
        self.record = Record(self.scope, self.mode, question.setting.load(name))
        tape = self.tape = self.record.field.tape
        self.limit, self.first = question.limit, max(question.after or Fraction(0), Fraction(0))
        positive = question.goal["kind"] == "always"
        self.claim = tape.truth(question.condition, not positive)
        self.domain = tape.truth(self.scope.modes[self.mode]["domain"], closed=True)
        ends = [(v["name"], op, e) for v in self.scope.automaton["vars"]
                for op, e in zip((">=", "<="), self.scope.window(v), strict=True) if e is not None]  # fmt: skip
        self.window = conj(tape.truth([op, ["var", v], e]) for v, op, e in ends)

    def _only_mode(self) -> str:
        """Where all runs start, and stay."""
        started = {line["mode"] for line in self.scope.automaton["init"]}
        started = set(self.scope.modes) if None in started else started
        mode = str(next(iter(started), None))
        if len(started) != 1 or self.model.leaving[mode] or self.scope.modes[mode]["terminal"]:
            raise Beyond("a flow with several modes, or one where a run may end")
        if any(t != "real" for t in self.scope.types.values()):
            raise Beyond("a flow beside discrete variables")
        return mode

    # Starts

    def admissible(self, start: Json) -> dict[str, Fraction]:
        """The values of an admissible start (S5), exactly."""
        given = {**start["values"], **start["params"]}
        if start["mode"] != self.mode or set(start["values"]) != set(self.scope.types) or \
                set(start["params"]) != set(self.scope.ranges):  # fmt: skip
            raise Refused("a start is of another mode, or does not give every param and variable a value")
        point = {v: number(q) for v, q in given.items()}
        ranges = [[op, ["param", p], line[end]] for p, line in self.scope.ranges.items()
                  for op, end in ((">=", "low"), ("<=", "high"))]  # fmt: skip
        window = [[op, ["var", v["name"]], e] for v in self.scope.automaton["vars"]
                  for op, e in zip((">=", "<="), self.scope.window(v), strict=True) if e is not None]  # fmt: skip
        held = [self._sure(e, point) for e in [*ranges, *window]]
        held.append(self._sure(self.scope.modes[self.mode]["domain"], point, True))
        lines = [self._sure(line["where"], point) and all(self._sure(e, point) for e in _assigned(line))
                 for line in self.scope.automaton["init"]]  # fmt: skip
        if not all(held) or not any(lines):
            raise Beyond("a start is not certainly admissible")
        return point

    def _sure(self, e: Json, point: Mapping[str, Fraction], closed: bool = False) -> bool:
        """Is a condition certainly true at a point?"""
        if isinstance(e, list) and e[:1] == ["and"]:
            return all(self._sure(f, point, closed) for f in e[1:])
        at = self.scope.identity(self.mode)
        here = Env({**{v: const(q) for v, q in point.items()}, "time": const(0), "sigma": const(0)})
        try:
            return bernstein.shown(placed(at.condition(e, closed=closed), here), self.scope.box)
        except Beyond:
            space, f = self.record.space, self.tape.truth(e, closed=closed)
            env = {v: space.number(q) for v, q in {**point, "time": Fraction(0)}.items()}
            return holds(f, self.tape.values(places(f), env, space)) is True

    def box(self, line: Json, given: Json) -> dict[str, Ends]:
        """The box that a record gives for an init line, which must hold all its starts."""
        ends = {v: (number(low), number(high)) for v, (low, high) in given.items()}
        starts = self._starts(line)
        for v, (low, high) in starts.items():
            if v in ends and not (ends[v][0] <= low and high <= ends[v][1]):
                raise Beyond(f"a recorded flow does not start everywhere: {v}")
        return {**starts, **ends}

    def _starts(self, line: Json) -> dict[str, Ends]:
        """Bounds of all starts: those of single variables in the line and the domain, else the declared ranges."""
        at, found = self.scope.identity(self.mode), dict.fromkeys(self.scope.types, bernstein.FREE)
        conditions = [(e, True) for e in _members(self.scope.modes[self.mode]["domain"])]
        for e, closed in [*conditions, *((e, False) for e in [*_members(line["where"]), *_assigned(line)])]:
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

    # Claims

    def shown(self, tree: Json, box: Mapping[str, Ends]) -> None:
        """The claim holds along all pieces of a tree of halves of the box."""
        spend(100)
        if "split" in tree:
            low, high = box[tree["split"]]
            middle = (low + high) / 2
            self.shown(tree["low"], {**box, tree["split"]: (low, middle)})
            self.shown(tree["high"], {**box, tree["split"]: (middle, high)})
            return
        for tube in self.record.tubes(box, tree["steps"], self.limit):
            if not self._close(tube, self._fits, CLOSE):
                raise Beyond(f"a claim is not shown along a recorded flow, from {float(tube.start):.6g} s on")

    def _fits(self, tube: Tube) -> bool | None:
        """The claim holds, in the declared ranges, or no run comes here."""
        if tube.start > self.limit:
            return True
        early = tube.end < self.first
        read = places(("and", self.claim, self.window, self.domain))
        values = self.tape.values(read, tube.states, self.record.space)
        if holds(self.domain, values) is False:
            return True
        return holds(self.window, values) is True and (early or holds(self.claim, values) is True)

    def _close(self, tube: Tube, fits: Callable[[Tube], bool | None], depth: int) -> bool:
        """Does something hold on a tube, or on both its halves?"""
        spend(20)
        if fits(tube):
            return True
        return depth > 0 and all(self._close(half, fits, depth - 1) for half in self._halves(tube))

    def _halves(self, tube: Tube) -> Iterator[Tube]:
        """A tube cut where its states vary most: in time, or in a set variable."""
        width = {-1: 0, **dict.fromkeys(range(len(self.record.set)), 0)}
        for m in tube.states.values():
            for i, terms in m.parts.items():
                for k, c in terms.items():
                    for v in [-1] * (i > 0) + [j for j, e in enumerate(exponents(k)) if e]:
                        width[v] += abs(c)
        cut = max(width, key=lambda v: width[v])
        space, middle = self.record.space, (tube.start + tube.end) / 2
        for a, b in HALF[min(cut, 0)]:
            half, whole = b * space.one >> 1, a * space.one >> 1
            part = Model({0: {0: whole, self.record.unit(cut): half}} if cut >= 0 else {0: {0: whole}, 1: {0: half}}, 0)
            states = {v: space.replaced(m, cut, part) for v, m in tube.states.items()}
            ends = (tube.start, tube.end) if cut >= 0 else (middle, tube.end) if a else (tube.start, middle)
            yield Tube(*ends, states)

    def violated(self, run: Json) -> None:
        """The run stays in its domain and in the declared ranges up to its last instant, where the claim is false."""
        point, last = self.admissible(run), number(run["last"])
        if run["steps"] or not self.first <= last <= self.limit:
            raise Refused("a run ends at an instant that the claim does not speak of")
        (start,) = self.record.data["starts"]
        for tube in self.record.tubes({v: (q, q) for v, q in point.items()}, start["pieces"]["steps"], last):
            done = tube.end >= last
            until = self._upto(tube, last, False) if done else tube
            if not self._close(until, self._possible, CLOSE):
                raise Beyond("a recorded run may leave its domain or the declared ranges")
            if done:
                end = self._upto(tube, last, True).states
                if holds(self.claim, self.tape.values(places(self.claim), end, self.record.space)) is not False:
                    raise Beyond("a recorded run does not certainly violate the claim at its end")
                return
        raise Beyond("a recorded run ends before its last instant")

    def _possible(self, tube: Tube) -> bool | None:
        values = self.tape.values(places(("and", self.window, self.domain)), tube.states, self.record.space)
        return holds(self.window, values) is True and holds(self.domain, values) is True

    def _upto(self, tube: Tube, last: Fraction, only: bool) -> Tube:
        """The tube up to an instant, or at that instant alone."""
        space = self.record.space
        share = space.number((last - tube.start) / (tube.end - tube.start))
        part = share if only else space.mul(share, Model({1: {0: space.one}}, 0))
        return Tube(tube.start, last, {v: space.replaced(m, -1, part) for v, m in tube.states.items()})


def _members(e: Json) -> Iterator[Json]:
    """The conjuncts of a condition."""
    if isinstance(e, list) and e[:1] == ["and"]:
        for f in e[1:]:
            yield from _members(f)
    else:
        yield e


def _assigned(line: Json) -> list[Json]:
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


def shown_along(question: Question, entry: Json) -> Shown:
    """The verdict that an entry of kind `flowpipe` or `flow_run` establishes."""
    if "flow" not in entry:
        raise Beyond("a flow without a record")
    along = Along(question, entry["flow"])
    question.same(entry, "flow", along.mode, "")
    positive = question.goal["kind"] == "always"
    if entry["kind"] == "flow_run":
        along.violated(entry["run"])
        verdict = "refuted" if positive else "proved"
    else:
        along.admissible(entry["start"])
        starts, lines = along.record.data["starts"], along.scope.automaton["init"]
        if len(starts) != len(lines):
            raise Refused("a recorded flow has other starts than the automaton")
        for given, line in zip(starts, lines, strict=True):
            along.shown(given["pieces"], along.box(line, given["box"]))
        verdict = "proved" if positive else "refuted"
    return verdict, [(along.mode, "", verdict)]
