"""Verdicts about random fuzzy systems: what is proved holds on a grid, what is refuted fails at its point."""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from random import Random

import pytest
from tests.unit.analyses.fuzzy_texts import core_of, spec_of

from hacheck.core import Core
from hacheck.fuzzy import fuzzy_goal
from haverify.analyses.fuzzy import decide_fuzzy
from haverify.evidence.verdict import Proved, Refuted
from haverify.model.core import to_core

Corners = dict[tuple[str, str], tuple[int, ...]]
GRID = [Fraction(k, 4) for k in range(17)]


def degree(corners: tuple[int, ...], x: Fraction) -> Fraction:
    """The degree, by the definition."""
    a, b, c, d = corners
    if not a <= x <= d:
        return Fraction(0)
    if x < b:
        return (x - a) / (b - a)
    return (d - x) / (d - c) if x > c else Fraction(1)


def random_spec(random: Random) -> tuple[str, Corners, list[tuple[tuple, str]], tuple]:
    corners = {(v, t): tuple(sorted(random.randrange(5) for _ in range(4))) for v in "xy" for t in "ab"}
    lines = ["fuzzy F {"]
    for v in "xy":
        terms = "; ".join(f"{t} = trap({', '.join(map(str, corners[v, t]))})" for t in "ab")
        lines.append(f"  input {v}: 1 over [0, 4] {{ {terms} }}")
    rules = [(premise(random, 2), t) for t in ("p", "q", random.choice("pq"))]
    lines += ["  output o { p, q }", *(f"  rule {written(e)} => o is {t}" for e, t in rules), "}"]
    claim = random_claim(random)
    return "\n".join([*lines, f"property c on F {{ holds {claim[0]} }}"]), corners, rules, claim[1:]


def premise(random: Random, depth: int) -> tuple:
    kind = random.choice(("is", "and", "or", "not")) if depth else "is"
    if kind == "is":
        return "is", random.choice("xy"), random.choice("ab")
    return kind, *(premise(random, depth - 1) for _ in range(1 if kind == "not" else 2))


def written(e: tuple) -> str:
    if e[0] == "is":
        return f"{e[1]} is {e[2]}"
    parts = [f"({written(p)})" for p in e[1:]]
    return f"not {parts[0]}" if e[0] == "not" else f" {e[0]} ".join(parts)


def strength(e: tuple, corners: Corners, at: dict[str, Fraction]) -> Fraction:
    if e[0] == "is":
        return degree(corners[e[1], e[2]], at[e[1]])
    parts = [strength(p, corners, at) for p in e[1:]]
    return 1 - parts[0] if e[0] == "not" else min(parts) if e[0] == "and" else max(parts)


def random_claim(random: Random) -> tuple:
    """A claim as text, and what it says of the strengths and the point."""
    op, other = random.choice(("<=", "<", ">=", ">", "==", "!=")), random.choice(("q", "half", "sum"))
    level = Fraction(random.randrange(1, 4), 4)
    right = {"q": "strength(q)", "half": str(float(level)), "sum": "1 - strength(q)"}[other]
    guard = random.choice(("", "x <= y", "x + y < 3", "strength(q) > 0.25"))
    return (
        f"{guard} implies strength(p) {op} {right}" if guard else f"strength(p) {op} {right}",
        op,
        other,
        level,
        guard,
    )


def says(claim: tuple, p: Fraction, q: Fraction, at: dict[str, Fraction]) -> bool:
    op, other, level, guard = claim
    if guard == "x <= y" and not at["x"] <= at["y"]:
        return True
    if guard == "x + y < 3" and not at["x"] + at["y"] < 3:
        return True
    if guard == "strength(q) > 0.25" and not q > Fraction(1, 4):
        return True
    right = {"q": q, "half": level, "sum": 1 - q}[other]
    return {"<=": p <= right, "<": p < right, ">=": p >= right, ">": p > right, "==": p == right, "!=": p != right}[op]


@pytest.mark.parametrize("block", range(8))
def test_verdicts_agree_with_the_definition(block):
    for seed in range(block * 15, block * 15 + 15):
        text, corners, rules, claim = random_spec(Random(seed))
        spec = spec_of(text)
        held = decide_fuzzy(spec, spec.claims[0], spec.claims[0].goals[0], to_core(spec), 400)
        assert isinstance(held.verdict, Proved | Refuted), seed
        core = Core(core_of(spec))
        listed = core.claims["c"]
        said = fuzzy_goal(core, listed, listed["goals"][0], held.entry)
        assert said == ("proved" if isinstance(held.verdict, Proved) else "refuted")

        def truth(at, corners=corners, rules=rules, claim=claim):
            p, q = (max((strength(e, corners, at) for e, t in rules if t == o), default=Fraction(0)) for o in "pq")
            return says(claim, p, q, at)

        if said == "proved":
            assert all(truth({"x": x, "y": y}) for x, y in product(GRID, GRID)), seed
        else:
            assert not truth({v: Fraction(q) for v, q in held.entry["point"].items()}), seed
