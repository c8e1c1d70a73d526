"""What a rule about flows accepts is kept by runs computed in floats."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction as Q
from random import Random
from typing import Any

import pytest

from hacheck.flows import Flow
from hacheck.formula import Formula, conj, literal, members, replace
from hacheck.functions import Functions
from hacheck.polynomial import ONE, Poly, add, const, mul, total, var
from hacheck.positivity import Premises, primitive
from hacheck.rational import Meter, Refused

NEAR, STEPS, DT = 1e-5, 200, 0.01
Box = dict[str, tuple[Q, Q]]
State = dict[str, float]


def some(r: Random) -> Q:
    return Q(r.randint(-4, 4), r.choice([1, 1, 2]))


def polynomial(r: Random, degree: int) -> Poly:
    def term() -> Poly:
        out = const(some(r))
        for _ in range(r.randint(0, degree)):
            out = mul(out, var(r.choice("xy")))
        return out

    return total((1, term()) for _ in range(r.randint(1, 3)))


def told(f: Formula) -> Any:
    """A formula as certificates have it."""
    if isinstance(f, bool):
        return f
    return [f[0], *map(told, f[1:])] if f[0] in ("and", "or") else [f[0], [[str(c), *m] for m, c in f[1].terms.items()]]


def value(p: Poly, at: State) -> float:
    found = 0.0
    for m, c in p.terms.items():
        product = c / p.unit
        for n in m:
            product *= at[n]
        found += product
    return found


def runs(r: Random, rates: dict[str, Poly], box: Box) -> Iterator[Iterator[State]]:
    """Runs from some points of the box, as long as they are in it."""

    def moved(at: State, slope: State, h: float) -> State:
        return {v: at[v] + h * slope[v] for v in at}

    def run(at: State) -> Iterator[State]:
        for _ in range(STEPS):
            if not all(low <= at[v] <= high for v, (low, high) in box.items()):
                return
            yield at
            middle = moved(at, {v: value(rates[v], at) for v in at}, DT / 2)
            at = moved(at, {v: value(rates[v], middle) for v in at}, DT)

    for _ in range(12):
        yield run({v: float(r.choice([*ends, Q(r.uniform(*map(float, ends)))])) for v, ends in box.items()})


def keep(r: Random, rule: str, f: Formula) -> Any:
    if rule == "barrier":
        return {"rule": rule, "proofs": ["b"] * len(members(f, "and"))}
    if rule == "growth":
        return {"rule": rule, "cofactor": [[str(some(r))]], "band": r.choice([None, "1/10"]), "proof": "b"}
    ranks = len({frozenset(g[1].terms.items()) for g in members(f, "and")})
    return {"rule": rule, "ranks": [[r.randint(1, 2), None, []]] * ranks, "forward": "b", "backward": "b"}


@pytest.mark.parametrize("rule", ["barrier", "growth", "lie"])
def test_runs_keep_what_a_rule_keeps(rule: str) -> None:
    accepted = 0
    for seed in range(150):
        r = Random(seed)
        rates = {v: polynomial(r, r.randint(0, 2)) for v in "xy"}
        box: Box = {v: (low, low + abs(some(r)) + 1) for v in "xy" for low in [some(r)]}
        inside = [literal(op, add(var(v), const(-q))) for v in "xy" for op, q in zip((">=", "<="), box[v], strict=True)]
        count = 1 if rule == "growth" else r.randint(1, 2)
        cut = replace(conj(literal(r.choice(["<", "<="]), polynomial(r, 2)) for _ in range(count)), primitive)
        if isinstance(cut, bool):
            continue
        flow = Flow(Premises(Functions(), inside), {**rates, "time": ONE}, {"x", "y"})
        proof = {"cuts": [{"formula": told(cut), "start": "t", "keep": keep(r, rule, cut)}], "end": "t"}
        Meter.left = 3_000_000
        try:
            flow.kept(proof, [cut], cut)
        except Refused:
            continue
        accepted += 1
        sides = [g[1] for g in members(cut, "and")]
        for run in runs(r, rates, box):
            first = next(run, None)
            if first is not None and all(value(p, first) < 0 for p in sides):
                assert all(value(p, at) <= 100 * NEAR for at in run for p in sides), (seed, cut, rates, box)
    assert accepted > 10
