"""What a system is as one automaton: interpreters and the second checker, which share nothing with it, agree."""

from __future__ import annotations

import json
from fractions import Fraction as Q
from math import prod
from typing import Any

from hypothesis import assume, given, settings
from hypothesis import strategies as st
from tests.unit.analyses.random_networks import COMPARE, Interpreter, Net, networks
from tests.unit.elaborate.texts import read

from hacheck.composed import Composed
from hacheck.core import Core
from hacheck.rational import Beyond, Meter
from haverify.analyses.networks.product import Product
from haverify.analyses.networks.whole import told
from haverify.model.core import to_core
from haverify.obligations.translate import OutsideFragmentError

Json = Any
CLAIMS = """
property p on S { never at(a.M0) and v == 1 and b.n == 2 }
property q on S { within 3 s; always jump(a.f) implies not at(b.M0) }
property r on S { reach jumped or a.x >= 1 s within 2 s }
"""


def put_together(text: str, left: set[int] | None = None, everywhere: bool = False) -> tuple[Json, Json, Json, Product]:
    """Core, the automaton's own core, that of the second checker; `left`: which of the modes found are left."""
    spec, _, _ = read(text)
    core = json.loads(json.dumps(to_core(spec)))
    try:
        product = Product(spec, core, "S", everywhere=everywhere)
    except OutsideFragmentError:
        assume(False)
    if left is not None:
        names = [product.named(m) for m in product.modes]
        product = Product(spec, core, "S", frozenset(names[k % len(names)] for k in left))
        product.list_edges({n for n in product.left or () if n in {product.named(m) for m in product.modes}})
    Meter.left = 60_000_000
    given = None if left is None else frozenset(product.left or ())
    mine = json.loads(json.dumps(to_core(told(product, spec.claims))))
    return core, mine, Composed(Core(core), core["systems"][0], given, everywhere), product


@given(networks(closed=False), st.one_of(st.none(), st.sets(st.integers(0, 30), max_size=4)))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_the_second_checker_puts_the_same_automaton_together(net: Net, left: set[int] | None) -> None:
    try:
        core, mine, theirs, product = put_together(net.text() + CLAIMS, left)
    except Beyond:
        assume(False)
    assert theirs.automaton == mine["automata"][0]
    assert theirs.open == product.open
    assert [theirs.claim(c) for c in core["claims"]] == mine["claims"]


@given(networks(closed=False))
@settings(max_examples=20, deadline=None, derandomize=True)
def test_everywhere_are_all_modes_and_those_of_runs_with_the_same_edges(net: Net) -> None:
    try:
        core, mine, theirs, _ = put_together(net.text() + CLAIMS, everywhere=True)
        _, _, some, _ = put_together(net.text() + CLAIMS)
    except Beyond:
        assume(False)
    assert theirs.automaton == mine["automata"][0]
    assert [theirs.claim(c) for c in core["claims"]] == mine["claims"]
    assert len(mine["automata"][0]["modes"]) == prod(len(p.domains) for p in net.parts)
    for kind in ("modes", "edges"):
        assert all(x in theirs.automaton[kind] for x in some.automaton[kind])


def value(e: Json, state: dict[str, Q], modes: str) -> Any:
    """An expression of the core at a state, exactly."""
    if isinstance(e, (str, bool)):
        return Q(e) if isinstance(e, str) else e
    op, args = e[0], e[1:]
    if op == "var":
        return state[args[0]]
    if op == "sym":
        return Q(args[1])
    found = [value(a, state, modes) for a in args]
    if op in COMPARE:
        return COMPARE[op](*found)
    if op == "if":
        return found[1] if found[0] else found[2]
    if op == "+":
        return found[0] + found[1]
    return {"and": all, "or": any}[op](found) if op != "not" else not found[0]


def results(a: Json, edge: Json, state: dict[str, Q], names: list[str], step: Q) -> list[tuple[Q, ...]]:
    """The states after an edge of an automaton, those of a range `step` apart; none where it is not enabled (S9)."""
    if not value(edge["guard"], state, edge["source"]):
        return []
    found = [dict(state)]
    for r in edge["resets"]:
        if "to" in r:
            values = [value(r["to"], state, edge["source"])]
        else:
            low, high = (value(r[k], state, edge["source"]) for k in ("low", "high"))
            values = [low + i * step for i in range(int((high - low) / step) + 1)]
        found = [{**f, r["var"]: q} for f in found for q in values]
    domain = next(m["domain"] for m in a["modes"] if m["name"] == edge["target"])
    return [tuple(f[n] for n in names) for f in found if value(domain, f, edge["target"])]


def named(parts: list[str], modes: tuple[int, ...]) -> str:
    return ", ".join(f"{p}.M{m}" for p, m in zip(parts, modes, strict=True))


POINT = st.tuples(st.integers(0, 2), st.integers(0, 2), st.integers(0, 14))


@given(networks(closed=False), st.lists(st.tuples(POINT, POINT, POINT, st.integers(0, 2)), min_size=4, max_size=12))
@settings(max_examples=40, deadline=None, derandomize=True)
def test_what_fires_where_is_what_an_interpreter_says(net: Net, points: list[Any]) -> None:
    _, mine, _, product = put_together(net.text())
    automaton, machine = mine["automata"][0], Interpreter(net, Q(1, 2))
    parts = [p.name for p in net.parts]
    names = ["v", *(f"{p}.{w}" for p in parts for w in "xn")]
    known = {m["name"] for m in automaton["modes"]}
    for *given_parts, v in points:
        modes, ns, xs = zip(*given_parts[: len(parts)], strict=True)
        state = (tuple(m % len(p.domains) for m, p in zip(modes, net.parts, strict=True)), ns, v,
                 tuple(Q(x, 4) for x in xs))  # fmt: skip
        here = named(parts, state[0])
        if here not in known:
            continue
        flat = {"v": Q(v), **{f"{p}.n": Q(n) for p, n in zip(parts, ns, strict=True)},
                **{f"{p}.x": x for p, x in zip(parts, state[3], strict=True)}}  # fmt: skip
        edges = [e for e in automaton["edges"] if e["source"] == here]
        found = {
            (product.names[e["name"]][0], e["target"], e["urgent"], r)
            for e in edges for r in results(automaton, e, flat, names, machine.step)
        }  # fmt: skip
        wanted = {
            (s.name, named(parts, r[0]), machine.is_urgent(state, s, None),
             (Q(r[2]), *(q for x, n in zip(r[3], r[1], strict=True) for q in (x, Q(n)))))
            for s, after in machine.enabled(state) for r in after
        }  # fmt: skip
        assert found == wanted, (here, flat)
