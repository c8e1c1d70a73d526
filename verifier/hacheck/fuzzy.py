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
from hacheck.rational import Beyond, Refused, number, spend
from hacheck.regions import (
    Node,
    Region,
    Truth,
    at_most,
    box,
    choice,
    combine,
    denied,
    holds_at,
    join,
    least,
    linear,
    minus,
)
from hacheck.regions import true_on as shown_on

Json = Any
ONE, ZERO = linear(Fraction(1)), linear(Fraction(0))
Value = tuple[Node, Truth]  # a number, and where it is defined
CORNERS = {"tri": 3, "trap": 4, "ramp": 2, "point": 1}


def slope(x: Node, zero: Fraction, one: Fraction) -> Node:
    """0 up to one corner and 1 from the other on, linear between; a step belongs to the 1."""
    if zero == one:
        return choice(at_most(linear(zero), x), ONE, ZERO)
    q = 1 / (one - zero)
    return least("max", [ZERO, least("min", [ONE, combine([(q, x)], -zero * q)])])


def membership(term: Json, x: Node) -> Node:
    """How far x belongs to a term."""
    corners = [number(c) for c in term["corners"]]
    if len(corners) != CORNERS.get(term["shape"]):
        raise Refused(f"the term {term['name']} has corners that do not fit its shape")
    if term["shape"] == "ramp":
        if corners[0] == corners[1]:
            raise Beyond("a ramp without a width")
        return slope(x, corners[0], corners[1])
    if corners != sorted(corners):
        raise Beyond("a term whose corners do not ascend")
    a, b, c, d = {1: corners * 4, 3: [*corners[:2], *corners[1:]], 4: corners}[len(corners)]
    falling = choice(at_most(x, linear(c)), ONE, ZERO) if c == d else slope(x, d, c)
    return least("min", [slope(x, a, b), falling])


class Systems:
    """The fuzzy systems of a core: degrees of terms and strengths, as functions of their real inputs."""

    def __init__(self, core: Core) -> None:
        self.of = by_name(core.data["fuzzy"], "fuzzy systems")
        self._memory: dict[tuple[str, ...], Node] = {}
        self._roots: dict[str, dict[str, Json]] = {}

    def system(self, name: str) -> Json:
        """The system, if its inference is understood."""
        if name not in self.of:
            raise Refused(f"there is no fuzzy system {name}")
        if self.of[name]["logic"] != ["min", "max"]:
            raise Beyond("inference other than by min and max")
        return self.of[name]

    def roots(self, name: str, depth: int = 0) -> dict[str, Json]:
        """The real inputs that a system reads, those of systems it is chained to included."""
        if depth > 50:
            raise Beyond("too long a chain of fuzzy systems")
        if name in self._roots:
            return self._roots[name]
        out: dict[str, Json] = {}
        for i in by_name(self.system(name)["inputs"], "fuzzy inputs").values():
            found = self.roots(i["source"][0], depth + 1) if i["source"] else {i["name"]: i}
            for n, root in found.items():
                if n in out and any(out[n][k] != root[k] for k in ("unit", "low", "high")):
                    raise Beyond("two inputs of one name with different units or ranges")
                out[n] = root
        spend(len(out))
        return self._roots.setdefault(name, out)

    def degree(self, name: str, word: str, term: str, at: dict[str, Node]) -> Node:
        """How far an input belongs to a term."""
        i = by_name(self.system(name)["inputs"], "fuzzy inputs").get(word)
        if i is None:
            raise Refused(f"{name} has no input {word}")
        if i["source"]:
            return self.strength(i["source"][0], i["source"][1], term, at)
        terms = by_name(i["terms"], "terms")
        if term not in terms:
            raise Refused(f"{word} has no term {term}")
        return self._remembered(("degree", name, word, term), at, lambda: membership(terms[term], at[word]))

    def terms(self, name: str, word: str) -> list[str]:
        """The terms of an input."""
        i = by_name(self.system(name)["inputs"], "fuzzy inputs").get(word)
        if i is None:
            raise Refused(f"{name} has no input {word}")
        return self.outputs(i["source"][0])[i["source"][1]] if i["source"] else [t["name"] for t in i["terms"]]

    def outputs(self, name: str) -> dict[str, list[str]]:
        """The terms of each output."""
        return {o["name"]: o["terms"] for o in by_name(self.system(name)["outputs"], "outputs").values()}

    def strength(self, name: str, output: str, term: str | None, at: dict[str, Node]) -> Node:
        """The greatest strength of the rules that conclude a term of an output (any term: None)."""
        terms = self.outputs(name).get(output)
        if terms is None or (term is not None and term not in terms):
            raise Refused(f"{name} has no such output or term")
        rules = [r for r in self.system(name)["rules"] if r["output"] == output and term in (None, r["term"])]

        def make() -> Node:
            return least("max", [self.premise(name, r["premise"], at) for r in rules] or [ZERO])

        return self._remembered(("strength", name, output, "" if term is None else "." + term), at, make)

    def premise(self, name: str, e: Json, at: dict[str, Node]) -> Node:
        """The strength of a premise."""
        spend(5)
        if e[0] == "is" and len(e) == 3:
            return self.degree(name, e[1], e[2], at)
        if e[0] in ("and", "or", "not") and (len(e) == 2 if e[0] == "not" else len(e) > 1):
            return self._remembered(("premise", name, json.dumps(e)), at, lambda: self._joined(name, e, at))
        raise Refused("a premise is none")

    def _joined(self, name: str, e: Json, at: dict[str, Node]) -> Node:
        parts = [self.premise(name, a, at) for a in e[1:]]
        return minus(ONE, parts[0]) if e[0] == "not" else least("min" if e[0] == "and" else "max", parts)

    def _remembered(self, key: tuple[str, ...], at: dict[str, Node], make: Any) -> Node:
        whole = (*key, *(f"{v}:{id(n)}" for v, n in sorted(at.items())))
        if whole not in self._memory:
            self._memory[whole] = make()
            self._memory.update({("", str(id(n))): n for n in at.values()})  # so that an id is of one node only
        return self._memory[whole]


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
            return self._compared("<=", self.number(args[2]), (least("max", [ZERO, *terms]), True), wanted)
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
            return linear(number(e)), True
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
            return combine([(number(args[0]), x[0])]), x[1]
        values = [self.number(a) for a in args]
        return self._applied(op, [v[0] for v in values]), join("and", [v[1] for v in values])

    def _applied(self, op: str, v: list[Node]) -> Node:
        if op in ("min", "max") and v:
            return least(op, v)
        if op == "+" and v:
            return combine([(Fraction(1), n) for n in v])
        if op == "-" and len(v) == 2:
            return minus(v[0], v[1])
        if op == "neg" and len(v) == 1:
            return minus(ZERO, v[0])
        if op == "abs" and len(v) == 1:
            return least("max", [v[0], minus(ZERO, v[0])])
        if op == "clamp" and len(v) == 3 and at_most(v[1], v[2]) is True:
            return least("min", [least("max", v[:2]), v[2]])
        if op in ("*", "/") and v:
            return self._multiple(op, v)
        raise Beyond(f"`{op}` in a claim on fuzzy systems")

    def _multiple(self, op: str, v: list[Node]) -> Node:
        """A product with one factor that is no number at most, a quotient by a number."""
        if op == "/" and (len(v) != 2 or v[1].names or v[1].op != "lin" or not v[1].parts[0]):
            raise Beyond("a division by what is no number")
        q, rest = Fraction(1), None
        for n in v:
            if n.op == "lin" and not n.names:
                q *= 1 / n.parts[0] if op == "/" and n is v[1] else n.parts[0]
            elif rest is None:
                rest = n
            else:
                raise Beyond("a product of two inputs")
        return combine([(q, rest)]) if rest is not None else linear(q)

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
            return linear(self.constant(args[0]))
        if op == "fuzzyinput":
            roots = self.systems.roots(args[0])
            if args[1] not in roots:
                raise Refused(f"{args[0]} has no input {args[1]}")
            return self.root(args[1], roots[args[1]])
        item = (self.params if op == "param" else self.inputs)[args[0]]
        if item.get("type", "real") != "real":
            raise Beyond(f"{args[0]} is no real number")
        ends = [self.number(item[k])[0] for k in ("low", "high")]
        if any(n.names or n.op != "lin" for n in ends):
            raise Beyond(f"the range of {args[0]} is not of numbers")
        return self._variable(op, args[0], (ends[0].parts[0], ends[1].parts[0]))

    def constant(self, name: str) -> Fraction:
        """The exact value of a constant."""
        if name not in self._known:
            self._depth += 1
            if name not in self.core.constants or self._depth > 200:
                raise Refused(f"there is no constant {name}, or it is defined by itself")
            n = self.number(self.core.constants[name]["value"])[0]
            if n.names or n.op != "lin":
                raise Beyond(f"the constant {name} is no exact number")
            self._known[name] = n.parts[0]
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
        return self._names.setdefault(name, linear(Fraction(0), {name: Fraction(1)}))

    def _tabled(self, args: Json) -> Value:
        """A table's column, held or linear between the points of one axis."""
        table, x = self.tables[args[0]], self.number(args[2])
        columns = [c["name"] for c in table["columns"]]
        if len(table["axes"]) != 1 or len(args) != 3 or table["columns"][columns.index(args[1])]["half"] is not None:
            raise Beyond("a table of two axes, or with tolerances")
        rows = [(number(r[0]), number(r[1 + columns.index(args[1])])) for r in table["rows"]]
        if not rows or any(a[0] >= b[0] for a, b in pairwise(rows)):
            raise Refused("the axis of a table does not increase")
        found = linear(rows[-1][1])
        for (t, y), (u, z) in reversed(list(pairwise(rows))):
            q = (z - y) / (u - t) if table["interpolate"] == "linear" else Fraction(0)
            found = choice(at_most(x[0], linear(u), True), combine([(q, x[0])], y - q * t), found)
        inside = join("and", [at_most(linear(rows[0][0]), x[0]), at_most(x[0], linear(rows[-1][0])), x[1]])
        return found, inside


def region_of(unfolding: Unfolding, assumed: list[Truth]) -> Region:
    """The ranges of the names; where an assumption bounds one side of a fuzzy input, that bound is the range's."""
    sides: dict[tuple[str, bool], Fraction] = {}
    for t in assumed:
        for part in () if isinstance(t, bool) else t.parts if t.op == "and" else (t,):
            found = _one_sided(part)
            if found is not None and unfolding.kinds[found[0]] == "fuzzyinput":
                name, upper, q = found
                old = sides.get((name, upper), q)
                sides[name, upper] = min(old, q) if upper else max(old, q)
    return box({v: (sides.get((v, False), low), sides.get((v, True), high))
                for v, (low, high) in unfolding.ranges.items()})  # fmt: skip


def _one_sided(t: Node) -> tuple[str, bool, Fraction] | None:
    """(name, is it an upper bound, the bound) of a comparison of one name with a number."""
    if t.op != "le" or any(n.op != "lin" for n in t.parts[:2]):
        return None
    line: Any = minus(t.parts[0], t.parts[1]).parts
    constant, terms = line
    return (terms[0][0], terms[0][1] > 0, -constant / terms[0][1]) if len(terms) == 1 else None


def fuzzy_goal(core: Core, claim: Json, goal: Json, entry: Json) -> str:
    """What an entry about a goal on fuzzy systems shows: `proved` by a region tree, `refuted` by a point."""
    if claim["which"]:
        raise Beyond("`for which` beside fuzzy systems")
    unfolding = Unfolding(core, claim)
    assumed = [unfolding.truth(a) for a in core.data["assumptions"] + claim["assume"]]
    wanted, missed = unfolding.truth(goal["condition"]), unfolding.truth(goal["condition"], False)
    region = region_of(unfolding, assumed)
    point = {v: number(q) for v, q in entry["point"].items()}
    ends = {d[0][0]: e for d, e in region.ends.items()}
    if set(point) != set(ends) or not all(low[0] <= point[v] <= high[0] for v, (low, high) in ends.items()):
        raise Refused("a point is not one of the inputs' ranges")
    if not all(holds_at(t, point) for t in assumed):
        raise Refused("a point does not keep what is assumed")
    if entry["kind"] == "point":
        if not holds_at(missed, point):
            raise Refused("a point does not violate the claim")
        return "refuted"
    shown_on(entry["tree"], join("or", [*map(denied, assumed), wanted]), region)
    return "proved"
