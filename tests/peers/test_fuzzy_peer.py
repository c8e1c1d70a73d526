"""Degrees and strengths agree with scikit-fuzzy on random systems and inputs."""

from __future__ import annotations

from fractions import Fraction
from random import Random

import numpy as np
import pytest
import skfuzzy
from tests.unit.analyses.fuzzy_texts import spec_of

from haverify.analyses.fuzzy_meaning import Meaning
from haverify.analyses.regions import value_at

TERMS = ("a", "b", "c")
CLOSE = 1e-9


def random_system(random: Random) -> tuple[str, dict[str, dict[str, list[Fraction]]], list[tuple[object, str]]]:
    """The text of a system of three inputs, the corners of its terms, and its rules as (premise, conclusion)."""
    corners: dict[str, dict[str, list[Fraction]]] = {}
    lines = ["fuzzy F {"]
    for name in ("x", "y", "z"):
        corners[name] = {
            t: sorted(Fraction(random.randrange(81), 8) for _ in range(random.choice((3, 4)))) for t in TERMS
        }
        shapes = {t: "tri" if len(c) == 3 else "trap" for t, c in corners[name].items()}
        written = "; ".join(
            f"{t} = {shapes[t]}({', '.join(str(float(q)) for q in c)})" for t, c in corners[name].items()
        )
        lines.append(f"  input {name}: 1 over [0, 10] {{ {written} }}")
    lines.append("  output o { p, q }")
    rules = [(random_premise(random, 3), random.choice("pq")) for _ in range(8)] + [(("is", "x", "a"), "p")]
    lines += [f"  rule {text_of(premise)} => o is {term}" for premise, term in rules]
    return "\n".join([*lines, "}"]), corners, rules


def random_corners(random: Random) -> list[Fraction]:
    """Corners of a triangle or a trapezoid, steps and points among them."""
    return sorted(Fraction(random.randrange(81), 8) for _ in range(random.choice((3, 4))))


def shape_text(corners: list[Fraction]) -> str:
    return f"{'tri' if len(corners) == 3 else 'trap'}({', '.join(str(float(q)) for q in corners)})"


def random_premise(random: Random, depth: int) -> tuple:
    kind = random.choice(("is", "and", "or", "not")) if depth else "is"
    if kind == "is":
        return "is", random.choice("xyz"), random.choice(TERMS)
    parts = [random_premise(random, depth - 1) for _ in range(1 if kind == "not" else 2)]
    return kind, *parts


def text_of(premise: tuple) -> str:
    kind, *parts = premise
    if kind == "is":
        return f"{parts[0]} is {parts[1]}"
    texts = [f"({text_of(p)})" for p in parts]
    return f"not {texts[0]}" if kind == "not" else f" {kind} ".join(texts)


def degree(corners: list[Fraction], at: Fraction) -> float:
    """The degree by scikit-fuzzy."""
    shape = skfuzzy.trimf if len(corners) == 3 else skfuzzy.trapmf
    return float(shape(np.array([float(at)]), [float(q) for q in corners])[0])


def strength(premise: tuple, degrees: dict[tuple[str, str], float]) -> float:
    """The strength of a premise by the functions for `and`, `or`, `not` of scikit-fuzzy's control systems."""
    kind, *parts = premise
    if kind == "is":
        return degrees[parts[0], parts[1]]
    values = [strength(p, degrees) for p in parts]
    return 1 - values[0] if kind == "not" else float((np.fmin if kind == "and" else np.fmax)(*values))


@pytest.mark.parametrize("seed", range(12))
def test_degrees_and_strengths_are_those_of_scikit_fuzzy(seed):
    random = Random(seed)
    text, corners, rules = random_system(random)
    meaning = Meaning(spec_of(text), "F")
    at = meaning.at("F")
    for _ in range(12):
        point = {v: Fraction(random.randrange(161), 16) for v in "xyz"}
        degrees = {(v, t): degree(c, point[v]) for v, terms in corners.items() for t, c in terms.items()}
        for (v, t), found in degrees.items():
            assert abs(value_at(meaning.systems.degree("F", v, t, at), point) - found) < CLOSE, (v, t, point)
        for term in "pq":
            expected = max((strength(p, degrees) for p, conclusion in rules if conclusion == term), default=0.0)
            assert abs(value_at(meaning.systems.strength("F", "o", term, at), point) - expected) < CLOSE
