"""Outputs that some modes do not have, and who refers to them there (HA601)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping

from haverify.elaborate.context import Context
from haverify.model.expression import Expr, nodes, operands
from haverify.model.hybrid import HybridAutomaton, Mode, Range


def missing_outputs(a: HybridAutomaton) -> dict[str, frozenset[str]]:
    """For each mode the outputs it does not have, those that read such ones included; empty where there is none."""
    given = {o.name for o in a.lets}
    some = {o.name for m in a.modes for o in m.lets}
    found = {}
    for mode in a.modes:
        absent = some - given - {o.name for o in mode.lets}
        if absent:
            found[mode.name] = _closed(a, mode, absent)
    return found


def _closed(a: HybridAutomaton, mode: Mode, absent: set[str]) -> frozenset[str]:
    exprs = {o.name: o.expr for o in a.lets} | {o.name: o.expr for o in mode.lets}
    reads = {name: {n.name for n in nodes(e) if n.op == "let"} for name, e in exprs.items()}
    while more := {name for name, r in reads.items() if r & absent} - absent:
        absent = absent | more
    return frozenset(absent)


def check_automaton(ctx: Context, a: HybridAutomaton) -> bool:
    """Whether every mode has the outputs that its domain, flow and edges read; else HA601."""
    missing = missing_outputs(a)
    for mode in a.modes:
        for e in _of_mode(a, mode) if mode.name in missing else ():
            if _report(ctx, e, mode.name, missing[mode.name]):
                return False
    return True


def _of_mode(a: HybridAutomaton, mode: Mode) -> Iterator[Expr]:
    yield mode.domain
    for line in mode.flow:
        yield from _ends(line.rate)
    for edge in a.edges:
        if edge.source == mode.name:
            yield edge.guard
            for r in edge.resets:
                yield from _ends(r.to)


def _ends(value: Expr | Range) -> tuple[Expr, ...]:
    return (value.low, value.high) if isinstance(value, Range) else (value,)


def check_claim(ctx: Context, conditions: Iterable[Expr], missing: Mapping[str, frozenset[str]]) -> bool:
    """Whether the conditions of a claim read outputs only in modes that have them; else HA601."""
    for e in conditions:
        for mode, names in missing.items():
            if _report(ctx, e, mode, names):
                return False
    return True


def _report(ctx: Context, e: Expr, mode: str, names: frozenset[str]) -> bool:
    use = _use(e, mode, names)
    if use is None:
        return False
    told = f"'{use.name}' is undefined in mode {mode}; guard it with `at(...) implies`"
    ctx.report("HA601", told, use.span or e.span)
    return True


def _use(e: Expr, mode: str, names: frozenset[str]) -> Expr | None:
    """An output among `names` that `e` reads in `mode`, where `at(...)` has the truth value it has there."""
    if e.op == "let":
        return e if e.name in names else None
    parts = _relevant(e, mode)
    for part in parts:
        found = _use(part, mode, names)
        if found is not None:
            return found
    return None


def _relevant(e: Expr, mode: str) -> tuple[Expr, ...]:
    """The operands that decide the value of `e` in `mode`."""
    parts = operands(e)
    if e.op in ("and", "or"):
        absorbing = e.op == "or"
        return () if any(_known(p, mode) is absorbing for p in parts) else parts
    if e.op == "implies":
        return () if _known(parts[0], mode) is False else parts
    if e.op == "if":
        known = _known(parts[0], mode)
        return parts if known is None else (parts[1] if known else parts[2],)
    return parts


def _known(e: Expr, mode: str) -> bool | None:
    """The truth value that knowing the mode alone gives."""
    if e.op in ("true", "false"):
        return e.op == "true"
    if e.op == "at":
        return e.name == mode
    if e.op == "not":
        inner = _known(operands(e)[0], mode)
        return None if inner is None else not inner
    if e.op in ("and", "or"):
        values = [_known(p, mode) for p in operands(e)]
        absorbing = e.op == "or"
        if absorbing in values:
            return absorbing
        return None if None in values else not absorbing
    return None
