"""Fuzzy systems of a core unfolded: degrees of terms and strengths as piecewise linear functions of real inputs."""

from __future__ import annotations

import json
from fractions import Fraction
from typing import Any

from hacheck.core import Core, by_name
from hacheck.lines import Node, at_most, choice, difference, line, pick, plus
from hacheck.rational import Beyond, Refused, number, spend

Json = Any
ONE, ZERO = line(Fraction(1)), line(Fraction(0))
CORNERS = {"tri": 3, "trap": 4, "ramp": 2, "point": 1}


def slope(x: Node, zero: Fraction, one: Fraction) -> Node:
    """0 up to one corner and 1 from the other on, linear between; a step belongs to the 1."""
    if zero == one:
        return choice(at_most(line(zero), x), ONE, ZERO)
    q = 1 / (one - zero)
    return pick("max", [ZERO, pick("min", [ONE, plus((1, line(-zero * q)), (q, x))])])


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
    falling = choice(at_most(x, line(c)), ONE, ZERO) if c == d else slope(x, d, c)
    return pick("min", [slope(x, a, b), falling])


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
            return pick("max", [self.premise(name, r["premise"], at) for r in rules] or [ZERO])

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
        return difference(ONE, parts[0]) if e[0] == "not" else pick("min" if e[0] == "and" else "max", parts)

    def _remembered(self, key: tuple[str, ...], at: dict[str, Node], make: Any) -> Node:
        whole = (*key, *(f"{v}:{id(n)}" for v, n in sorted(at.items())))
        if whole not in self._memory:
            self._memory[whole] = make()
            self._memory.update({("", str(id(n))): n for n in at.values()})  # so that an id is of one node only
        return self._memory[whole]
