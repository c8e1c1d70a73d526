"""The model and its claims as `core.json` (docs/core.md sections 1 to 3), and its expressions back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from fractions import Fraction
from typing import Any, TypeAlias

from haverify.model.cellular import CellularAutomaton, Relation
from haverify.model.claim import Claim, Expectation, Goal
from haverify.model.expression import Expr
from haverify.model.fuzzy import FuzzyController, FuzzyInput
from haverify.model.hybrid import (
    Assign,
    Constant,
    Edge,
    FlowLine,
    HybridAutomaton,
    Init,
    Input,
    Mode,
    Output,
    Param,
    Priority,
    Range,
    Variable,
)
from haverify.model.spec import Cell, EnumType, Spec, UnitDef
from haverify.model.system import Part, Sync, System
from haverify.model.tables import DataTable, Network
from haverify.model.unit import Unit

Json: TypeAlias = Any


def canonical(value: Json) -> bytes:
    """Canonical JSON: UTF-8, keys sorted, no blanks, one newline at the end."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False).encode() + b"\n"


def rational(q: Fraction) -> str:
    """A rational in lowest terms: `5`, `-106594/5`."""
    return str(q.numerator) if q.denominator == 1 else f"{q.numerator}/{q.denominator}"


# ---- expressions ----------------------------------------------------------------


def expr_to_json(e: Expr) -> Json:
    """An expression as in docs/core.md section 2."""
    if e.op == "num":
        value = e.args[0]
        assert isinstance(value, Fraction)
        return rational(value)
    if e.op in ("true", "false"):
        return e.op == "true"
    if e.op == "scale":
        return _scale(e)
    return [e.op, *[_arg(a) for a in e.args]]


def _scale(e: Expr) -> Json:
    q, k, operand = e.args
    assert isinstance(q, Fraction) and isinstance(k, Fraction) and isinstance(operand, Expr)
    return ["scale", rational(q), int(k), expr_to_json(operand)]


def _arg(a: Any) -> Json:
    if isinstance(a, Expr):
        return expr_to_json(a)
    if isinstance(a, Fraction):
        return rational(a)
    if isinstance(a, tuple):
        return [[k, expr_to_json(v)] for k, v in a]
    return a


_NAMES = {
    "const": 1, "param": 1, "input": 1, "var": 1, "let": 1, "bound": 1, "sym": 2, "at": 1, "jump": 1, "forall": 2,
    "exists": 2, "unique": 2, "next": 1, "unique_rule": 1, "related": 1, "apply": 1, "cell": 2, "covered": 2,
    "max_firing": 2, "strength": 2, "fuzzy": 2, "fuzzyinput": 2, "table": 2, "net": 2, "netinput": 2, "netoutput": 2,
    "is": 2,
}  # fmt: skip


def expr_from_json(value: Json) -> Expr:
    """The expression that `expr_to_json` writes as `value`, without units and places."""
    if isinstance(value, bool):
        return Expr("true" if value else "false")
    if isinstance(value, str):
        return Expr("num", (Fraction(value),))
    op, *args = value
    if op == "scale":
        return Expr(op, (Fraction(args[0]), Fraction(args[1]), expr_from_json(args[2])))
    if op == "field":
        return Expr(op, (expr_from_json(args[0]), args[1]))
    names = _NAMES.get(op, 0)
    rest = [_named(a) if op == "fuzzy" else expr_from_json(a) for a in args[names:]]
    return Expr(op, (*args[:names], *rest))


def _named(pairs: Json) -> tuple[tuple[str, Expr], ...]:
    return tuple((k, expr_from_json(v)) for k, v in pairs)


def _optional(e: Expr | None) -> Json:
    return None if e is None else expr_to_json(e)


# ---- declarations ---------------------------------------------------------------


def _unit(u: Unit | None) -> str | None:
    return None if u is None else u.text


def _low(r: Range | None) -> Json:
    return None if r is None else expr_to_json(r.low)


def _high(r: Range | None) -> Json:
    return None if r is None else expr_to_json(r.high)


def _value(v: Expr | Range) -> Json:
    return {"low": _low(v), "high": _high(v)} if isinstance(v, Range) else expr_to_json(v)


def _constant(c: Constant) -> Json:
    half = None if c.half is None else rational(c.half)
    return {"name": c.name, "type": c.type, "unit": _unit(c.unit), "value": _value(c.value), "half": half}


def _param(p: Param) -> Json:
    return {
        "name": p.name,
        "unit": _unit(p.unit),
        "low": _low(p.range),
        "high": _high(p.range),
        "default": _optional(p.default),
    }


def _input(i: Input) -> Json:
    return {
        "name": i.name, "type": i.type, "unit": _unit(i.unit), "low": _low(i.range), "high": _high(i.range),
        "rate_low": _low(i.rate), "rate_high": _high(i.rate), "every": _optional(i.every),
    }  # fmt: skip


def _var(v: Variable) -> Json:
    return {"name": v.name, "type": v.type, "unit": _unit(v.unit), "low": _low(v.range), "high": _high(v.range)}


def _let(o: Output) -> Json:
    return {"name": o.name, "type": o.type, "unit": _unit(o.unit), "expr": expr_to_json(o.expr)}


def _assign(a: Assign) -> Json:
    if isinstance(a.to, Range):
        return {"var": a.var, "low": _low(a.to), "high": _high(a.to)}
    return {"var": a.var, "to": expr_to_json(a.to)}


def _flow(f: FlowLine) -> Json:
    if isinstance(f.rate, Range):
        return {"var": f.var, "low": _low(f.rate), "high": _high(f.rate)}
    return {"var": f.var, "rate": expr_to_json(f.rate)}


def _init(i: Init) -> Json:
    return {"mode": i.mode, "where": expr_to_json(i.where), "with": [_assign(a) for a in i.assigns]}


def _mode(m: Mode) -> Json:
    return {
        "name": m.name, "domain": expr_to_json(m.domain), "flow": [_flow(f) for f in m.flow],
        "lets": [_let(o) for o in m.lets], "terminal": m.terminal,
    }  # fmt: skip


def _edge(e: Edge) -> Json:
    return {
        "name": e.name, "source": e.source, "target": e.target, "urgent": e.urgent, "guard": expr_to_json(e.guard),
        "resets": [_assign(a) for a in e.resets],
    }  # fmt: skip


def _priority(p: Priority) -> Json:
    return {"over": list(p.over), "when": expr_to_json(p.when)}


def _declared(m: HybridAutomaton | System) -> dict[str, Json]:
    return {
        "name": m.name, "constants": [_constant(c) for c in m.constants], "params": [_param(p) for p in m.params],
        "inputs": [_input(i) for i in m.inputs], "vars": [_var(v) for v in m.vars], "lets": [_let(o) for o in m.lets],
        "init": [_init(i) for i in m.init], "priorities": [_priority(p) for p in m.priorities],
    }  # fmt: skip


def automaton_to_json(a: HybridAutomaton) -> Json:
    """An automaton as in docs/core.md section 3."""
    return {**_declared(a), "modes": [_mode(m) for m in a.modes], "edges": [_edge(e) for e in a.edges]}


def _system(s: System) -> Json:
    return {
        **_declared(s), "parts": [_part(p) for p in s.parts], "syncs": [_sync(y) for y in s.syncs],
        "flow": [{"var": v, "rate": expr_to_json(e)} for v, e in s.flow],
    }  # fmt: skip


def _part(p: Part) -> Json:
    return {"name": p.name, "of": p.of, "bindings": [{"name": b.name, "to": _value(b.to)} for b in p.bindings]}


def _sync(y: Sync) -> Json:
    return {
        "name": y.name, "edges": list(y.edges), "listeners": list(y.listeners), "guard": expr_to_json(y.guard),
        "resets": [_assign(a) for a in y.resets], "broadcast": y.is_broadcast,
    }  # fmt: skip


# ---- finite things, data --------------------------------------------------------


def _cellular(c: CellularAutomaton) -> Json:
    return {
        "name": c.name, "cell": c.cell, "first": c.first, "second": c.second,
        "rules": [[r.left, r.right] for r in c.rules], "argument": c.argument, "formula": _optional(c.formula),
    }  # fmt: skip


def _relation(r: Relation) -> Json:
    return {"name": r.name, "pairs": [list(p) for p in r.pairs], "map": r.is_map}


def _fuzzy(f: FuzzyController) -> Json:
    return {
        "name": f.name, "inputs": [_fuzzy_input(i) for i in f.inputs],
        "outputs": [{"name": n, "terms": list(terms)} for n, terms in f.outputs], "logic": list(f.logic),
        "rules": [
            {"name": r.name, "premise": expr_to_json(r.premise), "output": r.output, "term": r.term} for r in f.rules
        ],
    }  # fmt: skip


def _fuzzy_input(i: FuzzyInput) -> Json:
    return {
        "name": i.name, "unit": _unit(i.unit), "low": None if i.low is None else rational(i.low),
        "high": None if i.high is None else rational(i.high), "source": None if i.source is None else list(i.source),
        "terms": [{"name": t.name, "shape": t.shape, "corners": [rational(c) for c in t.corners]} for t in i.terms],
    }  # fmt: skip


def _table(t: DataTable) -> Json:
    return {
        "name": t.name, "interpolate": t.interpolate, "axes": [{"name": n, "unit": _unit(u)} for n, u in t.axes],
        "columns": [{"name": n, "unit": _unit(u), "half": _half(h)} for n, u, h in t.columns],
        "rows": [[rational(q) for q in row] for row in t.rows],
    }  # fmt: skip


def _half(half: Fraction | str | None) -> str | None:
    return rational(half) if isinstance(half, Fraction) else half


def _network(n: Network) -> Json:
    return {
        "name": n.name, "file": n.file, "sha256": n.sha256,
        "inputs": [{"name": k, "unit": _unit(u)} for k, u in n.inputs],
        "outputs": [{"name": k, "unit": _unit(u)} for k, u in n.outputs],
    }  # fmt: skip


# ---- claims and the whole -------------------------------------------------------


def goal_to_json(g: Goal) -> Json:
    """A goal as in docs/core.md section 3."""
    window = None if g.window is None else [expr_to_json(e) for e in g.window]
    return {
        "kind": g.kind, "condition": expr_to_json(g.condition), "window": window, "within": _optional(g.within),
        "attracting": g.attracting,
    }  # fmt: skip


def horizon_to_json(c: Claim) -> Json:
    """How long a claim is about."""
    return {"time": _optional(c.time), "jumps": c.jumps}


def _claim(c: Claim) -> Json:
    return {
        "name": c.name, "on": c.on, "kind": c.kind, "goals": [goal_to_json(g) for g in c.goals],
        "horizon": horizon_to_json(c), "assume": [expr_to_json(e) for e in c.assume],
        "which": [{"name": n, "low": _low(r), "high": _high(r)} for n, r in c.which], "using": list(c.using),
        "method": None if c.method is None else {"name": c.method[0], "arguments": [list(a) for a in c.method[1]]},
        "expect": None if c.expect is None else _expect(c.expect), "inductive": c.inductive,
    }  # fmt: skip


def _expect(e: Expectation) -> Json:
    margin = None if e.margin is None else [e.margin[0], expr_to_json(e.margin[1]), _unit(e.margin[1].unit)]
    share = None if e.share is None else [e.share[0], rational(e.share[1])]
    return {"verdict": e.verdict, "margin": margin, "share": share, "because": e.because}


def _enum(e: EnumType) -> Json:
    ends = {"low": None if e.low is None else rational(e.low), "high": None if e.high is None else rational(e.high)}
    return {"name": e.name, "values": list(e.values), "codes": list(e.codes), **ends}


def _unit_def(u: UnitDef) -> Json:
    if u.value is None:
        return {"name": u.name, "value": None}
    q, k, dims = u.value
    return {"name": u.name, "value": [rational(q), k, {n: rational(e) for n, e in dims}]}


def _cell(c: Cell) -> Json:
    return {"file": c.file, "row": c.row, "column": c.column, "number": rational(c.number), "constant": c.constant}


def to_core(spec: Spec) -> Mapping[str, Json]:
    """The core of a spec: all a verdict rests on."""
    return {
        "schema": "haverify.core/1", "spec": {"name": spec.name, "version": spec.version, "unitless": spec.unitless},
        "units": [_unit_def(u) for u in spec.units], "enums": [_enum(e) for e in spec.enums],
        "constants": [_constant(c) for c in spec.constants], "params": [_param(p) for p in spec.params],
        "inputs": [_input(i) for i in spec.inputs], "tables": [_table(t) for t in spec.tables],
        "networks": [_network(n) for n in spec.networks], "assumptions": [expr_to_json(e) for e in spec.assumptions],
        "automata": [automaton_to_json(a) for a in spec.automata], "systems": [_system(s) for s in spec.systems],
        "cellular": [_cellular(c) for c in spec.cellular], "relations": [_relation(r) for r in spec.relations],
        "fuzzy": [_fuzzy(f) for f in spec.fuzzy], "claims": [_claim(c) for c in spec.claims],
        "cells": [_cell(c) for c in spec.cells],
    }  # fmt: skip
