"""What a claim bounds: the quantities to draw, with their bounds and the premises under which these count."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from haverify.report.figures.material import Json
from haverify.text.record import holder, record

_MIRROR = {"<": ">", "<=": ">=", ">": "<", ">=": "<=", "level": "level"}
_SIGNS = {"+": " + ", "*": " * ", "/": " / ", "^": "^"}


@record
class Bound:
    """`quantity op value` wherever the premises hold; `level`: a value that it is compared with at some instants."""

    op: str
    value: Any
    premises: tuple[Any, ...]


@holder
class Quantity:
    """An expression of the state with its name, unit and bounds; `has_jumps`: the claim is about its jumps."""

    expr: Any
    name: str
    unit: str
    bounds: list[Bound]
    has_jumps: bool = False

    @property
    def key(self) -> str:
        """What two quantities of one automaton are the same by."""
        return json.dumps(self.expr)


def quantities(claim: Json, automaton: Json) -> list[Quantity]:
    """The quantities that the `always` goals of a claim bound, in order of appearance; lets where it is about jumps.

    Of a goal in temporal logic those that it compares, with the levels that it compares them with.
    """
    found: dict[str, Quantity] = {}
    units = _units(automaton)
    for goal in claim.get("goals", []):
        if goal.get("kind") == "always" or claim.get("kind") == "invariant":
            for premises, comparison in _conjuncts(goal.get("condition"), ()):
                _enter(found, premises, comparison, units)
        elif goal.get("kind") == "stl":
            for comparison in _comparisons(goal.get("condition")):
                _enter(found, (), ["level", *comparison[1:]], units)
    return list(found.values())


def outputs(automaton: Json) -> list[Quantity]:
    """All outputs of an automaton, without bounds."""
    units = _units(automaton)
    return [Quantity(["let", name], name, units[name], []) for name in _lets(automaton)]


def _enter(found: dict[str, Quantity], premises: tuple[Any, ...], e: Any, units: dict[str, str]) -> None:
    if not isinstance(e, list) or len(e) != 3 or e[0] not in _MIRROR:
        return
    if any(op in _words([*premises, e]) for op in ("pre", "jump", "jumped")):
        for name in mentioned(e):
            _of(found, ["let", name], units).has_jumps = True
        return
    op, a, b = e
    if not mentioned(a) and mentioned(b):
        op, a, b = _MIRROR[op], b, a
    if mentioned(a) and mentioned(b):
        a, b = ["-", a, b], "0"
    if isinstance(a, list) and a and a[0] == "neg" and isinstance(b, str):
        op, a, b = _MIRROR[op], a[1], ["neg", b]
    if mentioned(a):
        _of(found, a, units).bounds.append(Bound(op, b, premises))


def _of(found: dict[str, Quantity], e: Any, units: dict[str, str]) -> Quantity:
    key = json.dumps(e)
    if key not in found:
        found[key] = Quantity(e, named(e), _unit(e, units), [])
    return found[key]


def _conjuncts(e: Any, premises: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], Any]]:
    if isinstance(e, list) and e and e[0] == "and":
        for x in e[1:]:
            yield from _conjuncts(x, premises)
    elif isinstance(e, list) and len(e) == 3 and e[0] == "implies":
        yield from _conjuncts(e[2], (*premises, e[1]))
    else:
        yield premises, e


def _comparisons(e: Any) -> Iterator[Any]:
    """All comparisons within a formula."""
    if not isinstance(e, list) or not e:
        return
    if e[0] in ("<", "<=", ">", ">=") and len(e) == 3:
        yield e
    else:
        for x in e[1:]:
            yield from _comparisons(x)


def _words(e: Any) -> set[str]:
    """The operators of expressions."""
    if not isinstance(e, list):
        return set()
    here = {e[0]} if e and isinstance(e[0], str) else set[str]()
    return here.union(*map(_words, e))


def mentioned(e: Any) -> list[str]:
    """The lets that an expression mentions."""
    if not isinstance(e, list) or not e:
        return []
    if e[0] == "let":
        return [str(e[1])]
    return list(dict.fromkeys(name for x in e[1:] for name in mentioned(x)))


def _lets(automaton: Json) -> list[str]:
    every = [*automaton.get("lets", []), *(x for m in automaton["modes"] for x in m.get("lets", []))]
    return list(dict.fromkeys(x["name"] for x in every if x.get("type") == "real"))


def _units(automaton: Json) -> dict[str, str]:
    every = [*automaton.get("lets", []), *(x for m in automaton["modes"] for x in m.get("lets", []))]
    return {x["name"]: x.get("unit") or "1" for x in every}


def _unit(e: Any, units: dict[str, str]) -> str:
    """The unit of an output, its absolute value or its derivatives; unknown for anything else."""
    if e[0] == "let":
        return units.get(e[1], "")
    if e[0] in ("abs", "neg"):
        return _unit(e[1], units)
    inner = _unit(e[1], units) if e[0] == "der" else ""
    return _per_second(inner) if inner else ""


def _per_second(unit: str) -> str:
    return f"{unit[:-2]}/s^2" if unit.endswith("/s") else "1/s" if unit == "1" else f"{unit}/s"


def named(e: Any) -> str:
    """A short name: the expression as people write it, as far as it is simple."""
    if not isinstance(e, list) or not e:
        return str(e)
    op, args = str(e[0]), e[1:]
    if op in ("let", "var", "const", "param"):
        return str(args[0])
    if op == "scale":
        return named(args[2])
    if op == "-" and len(args) == 2:
        return f"{named(args[0])} - {named(args[1])}"
    if op in _SIGNS:
        return _SIGNS[op].join(map(named, args))
    return f"{op}({', '.join(map(named, args))})"
