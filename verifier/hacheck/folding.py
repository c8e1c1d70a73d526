"""Conditions of a system where the mode of each part is known: what that decides is put in (docs/core.md section 7)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from hacheck.rational import Beyond, Refused, spend

Json = Any
OPPOSITE = {"<": ">=", ">=": "<", ">": "<=", "<=": ">", "==": "!=", "!=": "=="}
WEAK = {"<": "<=", ">": ">=", "<=": "<=", ">=": ">=", "==": "=="}


def joined(op: str, given: Iterable[Json]) -> Json:
    """`and` or `or` of conditions, truths left out."""
    neutral, kept = op == "and", []
    for e in given:
        if isinstance(e, bool):
            if e is not neutral:
                return e
        else:
            kept.append(e)
    return [op, *kept] if len(kept) > 1 else kept[0] if kept else neutral


def negation(e: Json) -> Json:
    """Where a condition fails."""
    return not e if isinstance(e, bool) else ["not", e]


def known(e: Json, modes: frozenset[str]) -> Json:
    """An expression in which it is put in which modes the parts are in."""
    spend(1)
    if not isinstance(e, list):
        return e
    op = e[0]
    if not isinstance(op, str):
        raise Beyond("arguments with names, in a system put together")
    if op == "at":
        return e[1] in modes
    args = [known(a, modes) for a in e[1:]]
    if op in ("and", "or"):
        return joined(op, args)
    if op == "not":
        return negation(args[0])
    if op == "implies" and isinstance(args[0], bool):
        return args[1] if args[0] else True
    if op == "if" and isinstance(args[0], bool):
        return args[1] if args[0] else args[2]
    return [op, *args]


def weakened(e: Json, is_wanted: bool = True) -> Json:
    """A domain as it is read (S6), or where it fails if that is wanted: bounds belong to it."""
    spend(1)
    if isinstance(e, bool):
        return e == is_wanted
    op, args = e[0], e[1:]
    if op == "not":
        return weakened(args[0], not is_wanted)
    if op == "implies":
        op, args = "or", [["not", args[0]], args[1]]
    if op in ("and", "or"):
        other = "or" if op == "and" else "and"
        return joined(op if is_wanted else other, [weakened(a, is_wanted) for a in args])
    sign = WEAK.get(op if is_wanted else OPPOSITE.get(op, ""))
    if sign is None:
        raise Beyond(f"a domain with `{op!s:.20}`, where it matters which jumps lead into it")
    return [sign, *args]


def earlier(e: Json, resets: Iterable[Json]) -> Json:
    """What a condition on the state after assignments says of the state before them."""
    values = {r["var"]: r.get("to") for r in resets}

    def put(e: Json) -> Json:
        spend(1)
        if not isinstance(e, list):
            return e
        if e[0] != "var" or e[1] not in values:
            return [e[0], *(put(a) for a in e[1:])]
        if values[e[1]] is None:
            raise Beyond("a value chosen from a range, where it matters which of them fit a domain")
        return values[e[1]]

    return put(e)


def only_known(e: Json) -> Json:
    """The expression itself.

    Raises
    ------
    Refused    if a let is read where it has no value
    """
    waiting = [e]
    while waiting:
        n = waiting.pop()
        if isinstance(n, list):
            if n[:1] == ["nothing"]:
                raise Refused("a let without a value is read")
            waiting += n[1:]
    return e
