"""Fuzzy systems unfolded from the core: what a `holds` goal about them says of real inputs.

Inference is min and max, terms are piecewise linear, so every number is built of linear ones by min, max and choice.
A number that is not defined (a choice where no rule fires, a table outside its axis) makes no comparison true.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from fractions import Fraction
from itertools import pairwise
from typing import Any

from hacheck.core import Core, by_name
from hacheck.formula import NEGATED
from hacheck.fuzzy_systems import ZERO, Systems
from hacheck.lines import Node, Truth, at_most, choice, constant, denied, difference, join, line, pick, plus
from hacheck.rational import Beyond, Refused, number, spend
from hacheck.region_trees import holds_at
from hacheck.region_trees import shown as tree_shown

Json = Any
Value = tuple[Node, Truth]  # a number, and where it is defined


class Unfolding:
    """A goal and what is assumed, as truths over the names of inputs and params; `ranges` of the names met."""

    def __init__(self, core: Core, claim: Json) -> None:
        self.core, self.on = core, claim["on"]
        self.systems = Systems(core)
        self.params = by_name(core.data["params"], "params")
        self.inputs = by_name(core.data["inputs"], "inputs")
        self.tables = by_name(core.data["tables"], "tables")
        self.ranges: dict[str, tuple[Fraction, Fraction]] = {}
        self.kinds: dict[str, str] = {}
        self._names: dict[str, Node] = {}
        self._known: dict[str, Fraction] = {}
        self._depth = 0
        self._memory: dict[str, Any] = {}  # so that equal parts are one node

    def once(self, e: Json, make: Callable[[], Any]) -> Any:
        """What was made of an expression before, or is made now."""
        key = json.dumps(e)
        spend(len(key))
        if key not in self._memory:
            self._memory[key] = make()
        return self._memory[key]

    # ---- truths

    def truth(self, e: Json, wanted: bool = True) -> Truth:
        """Where an expression is certainly true (certainly false, if that is wanted)."""
        spend(5)
        if isinstance(e, bool):
            return e is wanted
        op, args = e[0], e[1:]
        if op in ("and", "or") and args:
            return join("and" if (op == "and") is wanted else "or", [self.truth(a, wanted) for a in args])
        if op == "not" and len(args) == 1:
            return self.truth(args[0], not wanted)
        if op == "implies" and len(args) == 2:
            return join("or" if wanted else "and", [self.truth(args[0], not wanted), self.truth(args[1], wanted)])
        if op == "if" and len(args) == 3:
            cases = ((self.truth(args[0], c), self.truth(b, wanted)) for c, b in ((True, args[1]), (False, args[2])))
            return join("or", [join("and", c) for c in cases])
        if op == "covered" and len(args) == 3:
            terms = [self.systems.degree(args[0], args[1], t, self.at(args[0])) for t in self.systems.terms(*args[:2])]
            return self._compared("<=", self.number(args[2]), (pick("max", [ZERO, *terms]), True), wanted)
        if op in NEGATED and len(args) == 2:
            found: Truth = self.once([e, wanted], lambda: self._comparison(op, args, wanted))
            return found
        raise Beyond(f"`{op}` in a claim on fuzzy systems")

    def _comparison(self, op: str, args: Json, wanted: bool) -> Truth:
        if op in ("==", "!=") and (self._is_word(args[0]) or self._is_word(args[1])):
            return self._same(args[0], args[1], (op == "==") is wanted)
        return self._compared(op, self.number(args[0]), self.number(args[1]), wanted)

    def _compared(self, op: str, a: Value, b: Value, wanted: bool) -> Truth:
        op = op if wanted else NEGATED[op]
        if op in (">", ">="):
            return self._compared("<" + op[1:], b, a, True)
        if op in ("<", "<="):
            found = at_most(a[0], b[0], op == "<")
        else:
            both = at_most(a[0], b[0]), at_most(b[0], a[0])
            found = join("and", both) if op == "==" else join("or", map(denied, both))
        return join("and", [a[1], b[1], found])

    def _is_word(self, e: Json) -> bool:
        return isinstance(e, list) and (e[0] in ("sym", "fuzzy") or (e[0] == "if" and self._is_word(e[2])))

    def _same(self, a: Json, b: Json, wanted: bool) -> Truth:
        (left, known), (right, also) = self.word(a), self.word(b)
        both = join("or", [join("and", [left[w], right[w]]) for w in left if w in right])
        return join("and", [known, also, both if wanted else denied(both)])

    def word(self, e: Json) -> tuple[dict[str, Truth], Truth]:
        """For each value of an enumeration where it is the one meant, and where one is meant at all."""
        spend(5)
        if e[0] == "sym" and len(e) == 3:
            return {e[2]: True}, True
        if e[0] == "if" and len(e) == 4:
            yes, no = self.truth(e[1]), self.truth(e[1], False)
            (a, known), (b, also) = self.word(e[2]), self.word(e[3])
            cases = {w: join("or", [join("and", [yes, a.get(w, False)]), join("and", [no, b.get(w, False)])])
                     for w in {**a, **b}}  # fmt: skip
            return cases, self._branched(e[1], known, also)
        if e[0] == "fuzzy" and len(e) == 4:
            found: tuple[dict[str, Truth], Truth] = self.once(e, lambda: self._chosen(e[1], e[2], e[3]))
            return found
        raise Beyond(f"`{e[0]}` where a value of an enumeration is meant")

    def _branched(self, c: Json, a: Truth, b: Truth) -> Truth:
        """Where a choice is defined whose numbers are defined at `a` and at `b`."""
        known = self._settled(c)
        if all(x is True or x is known for x in (a, b)):
            return known
        cases = join("and", [self.truth(c), a]), join("and", [self.truth(c, False), b])
        return join("or", cases)

    def _settled(self, e: Json) -> Truth:
        """Where an expression is certainly true or certainly false."""
        if e[0] == "not" and len(e) == 2:
            return self._settled(e[1])
        if e[0] in ("==", "!=") and len(e) == 3 and (self._is_word(e[1]) or self._is_word(e[2])):
            parts = [p for p in (self.word(e[1])[1], self.word(e[2])[1]) if p is not True]
            return parts[0] if len(parts) == 1 else join("and", parts)
        if e[0] in NEGATED and len(e) == 3:
            return join("and", [self.number(a)[1] for a in e[1:]])
        return join("or", [self.truth(e), self.truth(e, False)])

    def _chosen(self, name: str, output: str, given: Json) -> tuple[dict[str, Truth], Truth]:
        """The strongest term, of equally strong ones the first declared; none where no rule fires."""
        roots = self.systems.roots(name)
        values = {v: self.number(x) for v, x in given}
        if sorted(values) != sorted(roots) or len(values) != len(given):
            raise Refused(f"{name} is applied to other inputs than it has")
        at = {v: x[0] for v, x in values.items()}
        terms = self.systems.outputs(name)[output]
        s = [self.systems.strength(name, output, t, at) for t in terms]
        best = self.systems.strength(name, output, None, at)
        known = join("and", [at_most(ZERO, best, True), *(x[1] for x in values.values())])
        return {t: join("and", [at_most(best, s[k]), *(at_most(u, s[k], True) for u in s[:k])])
                for k, t in enumerate(terms)}, known  # fmt: skip

    # ---- numbers

    def number(self, e: Json) -> Value:
        """A number, and where it is defined."""
        spend(5)
        if isinstance(e, str):
            return line(number(e)), True
        if isinstance(e, bool) or not isinstance(e, list):
            raise Refused("a number is none")
        op, args = e[0], e[1:]
        if op in ("const", "param", "input", "fuzzyinput", "strength", "max_firing"):
            return self._named(op, args), True
        if op == "table":
            return self._tabled(args)
        if op == "if" and len(args) == 3:
            a, b = self.number(args[1]), self.number(args[2])
            return choice(self.truth(args[0]), a[0], b[0]), self._branched(args[0], a[1], b[1])
        if op == "scale" and len(args) == 3 and args[1] == 0:
            x = self.number(args[2])
            return plus((number(args[0]), x[0])), x[1]
        values = [self.number(a) for a in args]
        return self._applied(op, [v[0] for v in values]), join("and", [v[1] for v in values])

    def _applied(self, op: str, v: list[Node]) -> Node:
        if op in ("min", "max") and v:
            return pick(op, v)
        if op == "+" and v:
            return plus(*((1, n) for n in v))
        if op == "-" and len(v) == 2:
            return difference(v[0], v[1])
        if op == "neg" and len(v) == 1:
            return difference(ZERO, v[0])
        if op == "abs" and len(v) == 1:
            return pick("max", [v[0], difference(ZERO, v[0])])
        if op == "clamp" and len(v) == 3 and at_most(v[1], v[2]) is True:
            return pick("min", [pick("max", v[:2]), v[2]])
        if op in ("*", "/") and v:
            return self._multiple(op, v)
        raise Beyond(f"`{op}` in a claim on fuzzy systems")

    def _multiple(self, op: str, v: list[Node]) -> Node:
        """A product with one factor that is no number at most, a quotient by a number."""
        if op == "/" and (len(v) != 2 or not constant(v[1])):
            raise Beyond("a division by what is no number")
        q, rest = Fraction(1), None
        for n in v:
            k = constant(n)
            if k is not None:
                q *= 1 / k if op == "/" and n is v[1] else k
            elif rest is None:
                rest = n
            else:
                raise Beyond("a product of two inputs")
        return plus((q, rest)) if rest is not None else line(q)

    def _named(self, op: str, args: Json) -> Node:
        if op in ("strength", "max_firing"):
            word, at = args[1], self.at(args[0])
            if op == "max_firing":
                return self.systems.strength(args[0], word, None, at)
            outputs = [o for o, terms in self.systems.outputs(args[0]).items() if word in terms]
            if len(outputs) != 1:
                raise Beyond("a term that belongs to no output, or to several")
            return self.systems.strength(args[0], outputs[0], word, at)
        if op == "const":
            return line(self.constant(args[0]))
        if op == "fuzzyinput":
            roots = self.systems.roots(args[0])
            if args[1] not in roots:
                raise Refused(f"{args[0]} has no input {args[1]}")
            return self.root(args[1], roots[args[1]])
        item = (self.params if op == "param" else self.inputs)[args[0]]
        if item.get("type", "real") != "real":
            raise Beyond(f"{args[0]} is no real number")
        low, high = (constant(self.number(item[k])[0]) for k in ("low", "high"))
        if low is None or high is None:
            raise Beyond(f"the range of {args[0]} is not of numbers")
        return self._variable(op, args[0], (low, high))

    def constant(self, name: str) -> Fraction:
        """The exact value of a constant."""
        if name not in self._known:
            self._depth += 1
            if name not in self.core.constants or self._depth > 200:
                raise Refused(f"there is no constant {name}, or it is defined by itself")
            q = constant(self.number(self.core.constants[name]["value"])[0])
            if q is None:
                raise Beyond(f"the constant {name} is no exact number")
            self._known[name] = q
            self._depth -= 1
        return self._known[name]

    def at(self, name: str) -> dict[str, Node]:
        """The inputs of a system as names; the claim's own system gives the ranges of those it shares."""
        return {v: self.root(v, i) for v, i in self.systems.roots(name).items()}

    def root(self, name: str, item: Json) -> Node:
        """An input of a fuzzy system as a name."""
        own: Json = self.systems.roots(self.on).get(name, item) if self.on in self.systems.of else item
        if own["unit"] != item["unit"]:
            raise Beyond("two inputs of one name with different units")
        return self._variable("fuzzyinput", name, (number(own["low"]), number(own["high"])))

    def _variable(self, kind: str, name: str, ends: tuple[Fraction, Fraction]) -> Node:
        if (self.kinds.setdefault(name, kind), self.ranges.setdefault(name, ends)) != (kind, ends):
            raise Beyond("two things of one name")
        return self._names.setdefault(name, line(0, {name: Fraction(1)}))

    def _tabled(self, args: Json) -> Value:
        """A table's column, held or linear between the points of one axis."""
        table, x = self.tables[args[0]], self.number(args[2])
        columns = [c["name"] for c in table["columns"]]
        if len(table["axes"]) != 1 or len(args) != 3 or table["columns"][columns.index(args[1])]["half"] is not None:
            raise Beyond("a table of two axes, or with tolerances")
        rows = [(number(r[0]), number(r[1 + columns.index(args[1])])) for r in table["rows"]]
        if not rows or any(a[0] >= b[0] for a, b in pairwise(rows)):
            raise Refused("the axis of a table does not increase")
        found = line(rows[-1][1])
        for (t, y), (u, z) in reversed(list(pairwise(rows))):
            q = (z - y) / (u - t) if table["interpolate"] == "linear" else Fraction(0)
            found = choice(at_most(x[0], line(u), True), plus((1, line(y - q * t)), (q, x[0])), found)
        inside = join("and", [at_most(line(rows[0][0]), x[0]), at_most(x[0], line(rows[-1][0])), x[1]])
        return found, inside


def ranges_of(unfolding: Unfolding, assumed: list[Truth]) -> dict[str, tuple[Fraction, Fraction]]:
    """The ranges of the names; where an assumption bounds one side of a fuzzy input, that bound is the range's."""
    sides: dict[tuple[str, bool], Fraction] = {}
    for t in assumed:
        for part in () if isinstance(t, bool) else t.parts if t.op == "and" else (t,):
            found = _one_sided(part)
            if found is not None and unfolding.kinds[found[0]] == "fuzzyinput":
                name, upper, q = found
                old = sides.get((name, upper), q)
                sides[name, upper] = min(old, q) if upper else max(old, q)
    return {v: (sides.get((v, False), low), sides.get((v, True), high))
            for v, (low, high) in unfolding.ranges.items()}  # fmt: skip


def _one_sided(t: Node) -> tuple[str, bool, Fraction] | None:
    """(name, is it an upper bound, the bound) of a comparison of one name with a number."""
    if t.op != "le" or any(n.op != "line" for n in t.parts[:2]):
        return None
    left, terms = difference(t.parts[0], t.parts[1]).parts
    return (terms[0][0], terms[0][1] > 0, -left / terms[0][1]) if len(terms) == 1 else None


def fuzzy_goal(core: Core, claim: Json, goal: Json, entry: Json) -> str:
    """What an entry about a goal on fuzzy systems shows: `proved` by a region tree, `refuted` by a point."""
    if claim["which"]:
        raise Beyond("`for which` beside fuzzy systems")
    unfolding = Unfolding(core, claim)
    assumed = [unfolding.truth(a) for a in core.data["assumptions"] + claim["assume"]]
    wanted, missed = unfolding.truth(goal["condition"]), unfolding.truth(goal["condition"], False)
    ranges = ranges_of(unfolding, assumed)
    point = {v: number(q) for v, q in entry["point"].items()}
    if set(point) != set(ranges) or not all(low <= point[v] <= high for v, (low, high) in ranges.items()):
        raise Refused("a point is not one of the inputs' ranges")
    if not all(holds_at(t, point) for t in assumed):
        raise Refused("a point does not keep what is assumed")
    if entry["kind"] == "point":
        if not holds_at(missed, point):
            raise Refused("a point does not violate the claim")
        return "refuted"
    tree_shown(entry["tree"], join("or", [*map(denied, assumed), wanted]), ranges)
    return "proved"
