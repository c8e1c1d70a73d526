"""Conditions and values of systems in one mode of all parts together, as JSON of the core (docs/core.md section 7)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from haverify.model.core import expr_from_json
from haverify.model.expression import Expr
from haverify.obligations.translate import OutsideFragmentError

Json = Any
CLOSED = {"<": "<=", "<=": "<=", ">": ">=", ">=": ">=", "==": "=="}
NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


def expression(e: Json) -> Expr:
    """The expression that some JSON is.

    Raises
    ------
    OutsideFragmentError    where it reads a let that has no value there
    """
    waiting = [e]
    while waiting:
        n = waiting.pop()
        if isinstance(n, list):
            if n[:1] == ["undefined"]:
                raise OutsideFragmentError(f"`{n[1]}` has no value in some mode in which it is read")
            waiting += n
    return expr_from_json(e)


def both(conditions: Iterable[Json]) -> Json:
    """All of them, with what is decided left out."""
    return _joined("and", conditions, True)


def either(conditions: Iterable[Json]) -> Json:
    """One of them at least, with what is decided left out."""
    return _joined("or", conditions, False)


def _joined(op: str, conditions: Iterable[Json], neutral: bool) -> Json:
    kept = [c for c in conditions if c is not neutral]
    if any(c is (not neutral) for c in kept):
        return not neutral
    return neutral if not kept else kept[0] if len(kept) == 1 else [op, *kept]


def denied(e: Json) -> Json:
    """Where a condition does not hold."""
    return (not e) if isinstance(e, bool) else ["not", e]


def settled(e: Json, present: frozenset[str]) -> Json:
    """An expression where the modes of the parts are known: `at`, and what it decides, is put in."""
    if not isinstance(e, list):
        return e
    if isinstance(e[0], list):  # arguments with names
        return [[name, settled(x, present)] for name, x in e]
    if e[0] == "at":
        return e[1] in present
    parts = [settled(x, present) for x in e[1:]]
    if e[0] in ("and", "or"):
        return both(parts) if e[0] == "and" else either(parts)
    if e[0] == "not":
        return denied(parts[0])
    if e[0] == "implies" and isinstance(parts[0], bool):
        return parts[1] if parts[0] else True
    if e[0] == "if" and isinstance(parts[0], bool):
        return parts[1] if parts[0] else parts[2]
    return [e[0], *parts]


def closed(e: Json, yes: bool = True) -> Json:
    """A domain (or its denial) as it is read: with the bounds closed (LANGUAGE S6).

    Raises
    ------
    OutsideFragmentError    where that is not a matter of its comparisons
    """
    if isinstance(e, bool):
        return e is yes
    op, *parts = e
    if op == "not":
        return closed(parts[0], not yes)
    if op == "implies":
        op, parts = "or", [["not", parts[0]], parts[1]]
    if op in ("and", "or"):
        return (both if (op == "and") is yes else either)(closed(x, yes) for x in parts)
    op = op if yes else NEGATED.get(op, op)
    if op not in CLOSED:
        raise OutsideFragmentError(f"a domain with `{op}`, where it matters which jumps into it are possible")
    return [CLOSED[op], *parts]


def assigned(e: Json, resets: Sequence[Mapping[str, Json]]) -> Json:
    """What an expression of the state after some assignments is before them.

    Raises
    ------
    OutsideFragmentError    where it reads a variable that may get any value of a range
    """
    if not isinstance(e, list):
        return e
    if isinstance(e[0], list):
        return [[name, assigned(x, resets)] for name, x in e]
    if e[0] == "var":
        found = next((r for r in resets if r["var"] == e[1]), None)
        if found is not None and "to" not in found:
            raise OutsideFragmentError(f"`{e[1]}` gets any value of a range, and it matters which of them fit a domain")
        return e if found is None else found["to"]
    return [e[0], *(assigned(x, resets) for x in e[1:])]
