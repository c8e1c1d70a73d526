"""Premises that have a common point are not refuted, whatever the proof says."""

from __future__ import annotations

import math
from fractions import Fraction as Q
from random import Random
from typing import Any

import pytest

from hacheck.formula import conj, disj, literal
from hacheck.functions import Functions
from hacheck.polynomial import Poly, add, const, mul, scale, total, var
from hacheck.positivity import Premises, refute
from hacheck.rational import Meter, Refused

Json = Any
NAMES = ("x", "y", "z")
FAULTS = (Refused, KeyError, IndexError, TypeError, ValueError)


class World:
    """A random point, and formulas that are true there, functions included."""

    def __init__(self, seed: int) -> None:
        self.r, self.functions = Random(seed), Functions()
        self.point = {n: Q(self.r.randint(-6, 6), self.r.choice([1, 2, 3])) for n in NAMES}
        self.own: dict[str, Poly] = {}

    def polynomial(self) -> Poly:
        """Up to three terms of low degree, perhaps with a function."""
        terms = []
        for _ in range(self.r.randint(1, 3)):
            p = const(Q(self.r.randint(-4, 4), self.r.choice([1, 2])))
            for _ in range(self.r.randint(0, 2)):
                p = mul(p, var(self.r.choice(NAMES)))
            terms.append((1, p))
        if self.r.random() < 0.3:
            a = add(scale(var(self.r.choice(NAMES)), Q(self.r.randint(-2, 2), 2)), const(self.r.randint(-1, 1)))
            terms.append((self.r.choice([1, -2]), self.functions.apply(self.r.choice(["sin", "cos", "exp"]), a)))
        return total(terms)

    def value(self, p: Poly) -> float:
        """The value at the point."""
        out = 0.0
        for m, c in p.terms.items():
            out += c / p.unit * math.prod(self.of(n) for n in m)
        return out

    def of(self, name: str) -> float:
        if name in self.point:
            return float(self.point[name])
        op, a = self.functions.known[name]
        return float(getattr(math, op)(self.value(a)))

    def true_literal(self) -> Any:
        """A literal that holds at the point, with room where a function occurs."""
        p = self.polynomial()
        v = self.value(p)
        if abs(v) < 1e-6:
            return literal(self.r.choice(["<=", "==", ">="]), p) if not p.terms or v == 0 else True
        if all(n in NAMES for m in p.terms for n in m) and self.r.random() < 0.4:
            exact = Q(0)
            for m, c in p.terms.items():
                exact += Q(c, p.unit) * math.prod((self.point[n] for n in m), start=Q(1))
            return literal(self.r.choice(["==", "<=", ">="]), add(p, const(exact), -1))
        return literal(self.r.choice(["<", "<=", "!="] if v < 0 else [">", ">=", "!="]), p)

    def true_formula(self) -> Any:
        if self.r.random() < 0.3:
            members = [self.true_literal(), literal(self.r.choice(["<", "==", "<="]), self.polynomial())]
            self.r.shuffle(members)
            return disj(members)
        return conj([self.true_literal()])

    def proof(self, known: int, depth: int) -> Json:
        """A random proof that fits the grammar."""
        r = self.r
        kind = r.choice(["t", "b", "b", "or", "cut", "s", "put", "fact", "psatz"]) if depth else r.choice(["t", "b"])
        index = r.randrange(max(1, known))
        if kind == "or":
            return ["or", index, [self.proof(known + 1, depth - 1) for _ in range(2)]]
        if kind == "cut":
            p = [[str(r.randint(-2, 2)), r.choice(NAMES)], [str(r.randint(-2, 2))]]
            halves = [self.proof(known + 1, depth - 1) for _ in range(2)]
            return ["cut", [r.choice(["<", "<=", "==", "!="]), p], *halves]
        if kind == "s":
            halves = [self.proof(known + 1, depth - 1) for _ in range(2)]
            return ["s", r.choice(NAMES), str(r.randint(-3, 3)), *halves]
        if kind == "put":
            return ["put", index, r.choice(NAMES), self.proof(known, depth - 1)]
        if kind == "fact":
            name = r.choice([*self.functions.known, "pi"])
            what = r.choice(["circle", "positive", "series"])
            about = [what, name, *([r.randint(1, 4)] if what == "series" else [])] if name != "pi" else ["pi"]
            return ["fact", *about, self.proof(known + 1, depth - 1)]
        if kind == "psatz":
            last = [str(r.randint(1, 2)), [r.randrange(max(1, known))]]
            return ["psatz", [[str(r.randint(0, 2)), [index]]], [], last]
        return kind


@pytest.mark.parametrize("batch", range(8))
def test_what_has_a_common_point_is_not_refuted(batch: int) -> None:
    for seed in range(batch * 150, batch * 150 + 150):
        Meter.left = 60_000_000
        world = World(seed)
        known = Premises(world.functions, [world.true_formula() for _ in range(world.r.randint(1, 5))])
        for _ in range(6):
            proof = world.proof(len(known.entries), 3)
            with pytest.raises(FAULTS):
                refute(proof, known)
                raise AssertionError((seed, known.entries, proof))
