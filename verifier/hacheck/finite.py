"""Goals about cells, rules and relations: read from the core, and evaluated for every value of the bound names.

A value is a cell `(set, bits)`, the name of an enumeration value, a Fraction or a truth; None where it is undefined.
Truths are Kleene's: what an undefined value decides is neither true nor false, whatever stands beside it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from fractions import Fraction
from functools import reduce
from typing import Any

from hacheck.core import Core, by_name
from hacheck.rational import MAX_BITS, Beyond, Refused, number, spend

Json = Any
Cell = tuple[str, str]
Env = dict[str, Cell]
Truth = bool | None
Masks = tuple[int, int]  # the cells where a truth holds, and where it does not: bit i for cell i
MOST_CELLS = 1 << 14
_CODE = re.compile(r"0b[01]{1,64}|[0-9]{1,18}", re.ASCII)
QUANTIFIERS = {"forall", "exists", "unique"}
TRUTHS = {"and", "or", "not", "implies", "forall", "exists", "unique", "defined", "unique_rule", "related"}
COMPARED: dict[str, Callable[[Any, Any], bool]] = {
    "==": lambda a, b: a == b, "!=": lambda a, b: a != b, "<": lambda a, b: a < b, "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b, ">=": lambda a, b: a >= b}  # fmt: skip


def codes(enum: Json) -> list[str]:
    """The bits of each value of an enumeration: as written, numbers in binary, positions where nothing is written."""
    given = enum.get("codes")
    if not isinstance(given, list) or len(given) != len(enum["values"]):
        raise Refused(f"the enumeration {enum['name']!a} does not give each value a code")
    written = [str(i) if c is None else c for i, c in enumerate(given)]
    if not written or not all(isinstance(c, str) and _CODE.fullmatch(c) for c in written):
        raise Beyond(f"the codes of {enum['name']!a} are no bits")
    numbers = [int(c[2:], 2) if c.startswith("0b") else int(c) for c in written]
    widths = [len(c) - 2 for c in written if c.startswith("0b")] or [max(numbers).bit_length() or 1]
    bits = [format(n, "b").rjust(max(widths), "0") for n in numbers]
    if len({len(b) for b in bits}) > 1 or len(set(bits)) < len(bits):
        raise Beyond(f"two values of {enum['name']!a} have one code, or codes of two lengths")
    return bits


class World:
    """What the names of cells, rules and relations stand for."""

    def __init__(self, core: Core, on: str | None, params: dict[str, Fraction] | None = None) -> None:
        own = core.automata[on]["constants"] if on in core.automata else []
        self.enums, self.params = core.enums, params or {}
        self.constants = {**core.constants, **by_name(own, "constants")}
        self.automata = by_name(core.data["cellular"], "cellular automata")
        self.relations = by_name(core.data["relations"], "relations")
        self.sets: dict[str, list[Cell]] = {}
        self.fields: dict[tuple[Cell, str], Any] = {}
        for a in self.automata.values():
            self._enter(a["cell"], a["first"], a["second"])
        self._steps: dict[str, dict[Cell, tuple[Cell | None, int]] | None] = {}
        self._images: dict[str, dict[str, set[str]]] = {}
        self._constants: dict[str, Any] = {}

    def _enter(self, name: str, first: str, second: str) -> None:
        """The cells of an automaton; several automata may have the same."""
        if first.lower() == second.lower() or name in self.enums:
            raise Refused(f"the parts of the cells {name!a} have one name")
        left, right = codes(self.enums[first]), codes(self.enums[second])
        spend(len(left) * len(right))
        if len(left) * len(right) > MOST_CELLS:
            raise Beyond(f"there are more than {MOST_CELLS} cells")
        cells = [(name, a + b) for a in left for b in right]
        parts = [(x, y) for x in self._values(first) for y in self._values(second)]
        found = {}
        for cell, (x, y) in zip(cells, parts, strict=True):
            found[cell, first.lower()], found[cell, second.lower()] = x, y
        if self.sets.setdefault(name, cells) != cells or any(self.fields.get(k, v) != v for k, v in found.items()):
            raise Refused(f"the cells {name!a} are two things")
        self.fields.update(found)

    def _values(self, enum: str) -> list[Any]:
        """The values of an enumeration: names, or the integers of `a..b`."""
        found = self.enums[enum]
        if found["low"] is None:
            return list(found["values"])
        return [number(found["low"]) + i for i in range(len(found["values"]))]

    def value_of(self, enum: str, value: str) -> Any:
        """A value of an enumeration, by its name."""
        if enum not in self.enums or value not in self.enums[enum]["values"]:
            raise Refused(f"there is no value {value!a} of {enum!a}")
        return self._values(enum)[self.enums[enum]["values"].index(value)]

    def step(self, automaton: str, cell: Any) -> tuple[Cell | None, int]:
        """Where an automaton leads from a cell (None: nowhere, or to two places), and how many rules say so."""
        if automaton not in self._steps:
            self._steps[automaton] = None  # while it is being read: a formula that asks for itself has no meaning
            self._steps[automaton] = self._read(self.automata[automaton])
        steps = self._steps[automaton]
        if steps is None or cell not in steps:
            raise Refused(f"{automaton!a} is asked about something that is none of its cells")
        return steps[cell]

    def _read(self, a: Json) -> dict[Cell, tuple[Cell | None, int]]:
        results: dict[Cell, list[Cell]] = {c: [] for c in self.sets[a["cell"]]}
        for left, right in a["rules"]:
            spend(2)
            source, target = (a["cell"], left), (a["cell"], right)
            if source not in results or target not in results:
                raise Refused(f"a rule of {a['name']!a} speaks of something that is no cell")
            results[source].append(target)
        if a["formula"] is not None:
            for cell, found in results.items():
                target = Finite(self).value(a["formula"], {a["argument"]: cell})
                if target is not None:
                    if target not in results:
                        raise Refused(f"the formula of {a['name']!a} leads to something that is no cell")
                    found.append(target)
        return {c: (r[0] if len(set(r)) == 1 else None, len(r)) for c, r in results.items()}

    def images(self, relation: str) -> dict[str, set[str]]:
        """What each name is related to."""
        if relation not in self._images:
            out: dict[str, set[str]] = {}
            for a, b in self.relations[relation]["pairs"]:
                out.setdefault(a, set()).add(b)
            self._images[relation] = out
        return self._images[relation]

    def constant(self, name: str) -> Any:
        """The value of a constant."""
        if name not in self._constants:
            self._constants[name] = Finite(self).value(self.constants[name]["value"], {})
        return self._constants[name]


def all_of(truths: Iterable[Truth]) -> Truth:
    """False if one is false; true if all are true; else undecided."""
    out: Truth = True
    for t in truths:
        if t is False:
            return False
        out = None if t is None else out
    return out


def deny(t: Truth) -> Truth:
    """The opposite."""
    return None if t is None else not t


class Finite:
    """Expressions evaluated for values of their bound names; what was found for the same values is kept."""

    def __init__(self, world: World) -> None:
        self.world = world
        self._free: dict[int, tuple[Json, frozenset[str]]] = {}  # with the expression, so that its id stays its own
        self._plain: dict[int, tuple[Json, bool]] = {}
        self._known: dict[Any, Any] = {}

    def free(self, e: Json) -> frozenset[str]:
        """The names an expression reads that none of its own quantifiers binds."""
        if not isinstance(e, list):
            return frozenset()
        if id(e) not in self._free:
            inner = frozenset[str]().union(*map(self.free, e[1:]))
            if e[0] == "bound":
                inner = frozenset(e[1:])
            self._free[id(e)] = e, inner - {e[1]} if e[0] in QUANTIFIERS else inner
        return self._free[id(e)][1]

    def plain(self, e: Json) -> bool:
        """Are there no quantifiers in it?"""
        if not isinstance(e, list):
            return True
        if id(e) not in self._plain:
            self._plain[id(e)] = e, e[0] not in QUANTIFIERS and all(map(self.plain, e[1:]))
        return self._plain[id(e)][1]

    # ---- truths -------------------------------------------------------------------

    def truth(self, e: Json, env: Env) -> Truth:
        """True, false, or None where something undefined decides."""
        spend(2)
        if isinstance(e, bool):
            return e
        op, *args = e
        if op == "and":
            return all_of(self.truth(a, env) for a in args)
        if op == "or":
            return deny(all_of(deny(self.truth(a, env)) for a in args))
        if op == "not":
            (a,) = args
            return deny(self.truth(a, env))
        if op == "implies":
            a, b = args
            return deny(all_of((self.truth(a, env), deny(self.truth(b, env)))))
        if op in QUANTIFIERS:
            return self._quantified(e, env)
        if op == "if":
            c, a, b = args
            chosen = self.truth(c, env)
            return None if chosen is None else self.truth(a if chosen else b, env)
        return self._compared(op, args, env) if op in COMPARED else self._asked(op, args, env)

    def _compared(self, op: str, args: list[Json], env: Env) -> Truth:
        left, right = args
        a, b = self.value(left, env), self.value(right, env)
        if a is None or b is None:
            return None
        if type(a) is not type(b) or (op not in ("==", "!=") and not isinstance(a, Fraction)):
            raise Refused("a comparison of different things, or of things without order")
        return COMPARED[op](a, b)

    def _asked(self, op: str, args: list[Json], env: Env) -> Truth:
        if op == "defined":
            (a,) = args
            return self.value(a, env) is not None
        if op not in ("related", "unique_rule"):
            raise Beyond(f"`{op!s:.20}` in a goal about rules and relations")
        of, a = args
        value = self.value(a, env)
        if value is None:
            return None
        return value in self.world.images(of) if op == "related" else self.world.step(of, value)[1] == 1

    def _quantified(self, e: Json, env: Env) -> Truth:
        """A quantifier over cells; where nothing below it quantifies, over all cells at once."""
        kind, name, of, body = e
        key = id(e), *(env[n] for n in sorted(self.free(e)))
        if key not in self._known:
            cells = self.world.sets[of]
            if self.plain(body):
                masks = self.masks(body, env, name, of)
            else:
                masks = _masks([self.truth(body, {**env, name: c}) for c in cells])
            self._known[key] = _decided(kind, *masks, len(cells))
        found: Truth = self._known[key]
        return found

    # ---- truths for all cells at once ------------------------------------------------

    def masks(self, e: Json, env: Env, name: str, of: str) -> Masks:
        """For which cells, as the value of `name`, a quantifier-free truth holds, and for which it does not."""
        cells = self.world.sets[of]
        spend(2 + len(cells) // 2000)
        if name not in self.free(e):
            known, everywhere = self.truth(e, env), (1 << len(cells)) - 1
            return everywhere * (known is True), everywhere * (known is False)
        op, *args = e
        if op in ("and", "or", "not", "implies"):
            return _joined(op, [self.masks(a, env, name, of) for a in args])
        if op in ("==", "!=") and any(name not in self.free(a) for a in args):
            yes, no = self._same(args, env, name, of)
            return (yes, no) if op == "==" else (no, yes)
        if self.free(e) != {name}:
            return _masks([self.truth(e, {**env, name: c}) for c in cells])
        key = "masks", id(e), name, of
        if key not in self._known:
            self._known[key] = _masks([self.truth(e, {name: c}) for c in cells])
        found: Masks = self._known[key]
        return found

    def _same(self, args: list[Json], env: Env, name: str, of: str) -> Masks:
        """Where a term equals another that does not read `name`."""
        left, right = args
        fixed, moving = (left, right) if name not in self.free(left) else (right, left)
        wanted = self.value(fixed, env)
        key = "places", id(moving), name, of, *((n, env[n]) for n in sorted(self.free(moving) - {name}))
        if key not in self._known:
            self._known[key] = self._places(moving, env, name, of)
        places, kinds, known = self._known[key]
        if wanted is None:
            return 0, 0
        if kinds - {type(wanted)}:
            raise Refused("a comparison of different things")
        yes: int = places.get(wanted, 0)
        return yes, known & ~yes

    def _places(self, e: Json, env: Env, name: str, of: str) -> tuple[dict[Any, int], set[type], int]:
        """For which cells a term has each of its values, the kinds of these, and where it has one."""
        values = [self.value(e, {**env, name: c}) for c in self.world.sets[of]]
        found: dict[Any, list[int]] = {}
        for i, v in enumerate(values):
            if v is not None:
                found.setdefault(v, []).append(i)
        spend((len(found) + 1) * (1 + len(values) // 2000))
        known, _ = _masks([v is not None for v in values])
        return {v: sum(1 << i for i in at) for v, at in found.items()}, {type(v) for v in found}, known

    def value(self, e: Json, env: Env) -> Any:
        """The value of an expression, None where it is undefined."""
        spend(2)
        if isinstance(e, str):
            return number(e)
        if isinstance(e, bool) or e[0] in TRUTHS or e[0] in COMPARED:
            return self.truth(e, env)
        op, *args = e
        if op == "if":
            c, a, b = args
            chosen = self.truth(c, env)
            return None if chosen is None else self.value(a if chosen else b, env)
        if op in ("bound", "const", "param"):
            (name,) = args
            return env[name] if op == "bound" else self.world.constant(name) if op == "const" else self._param(name)
        if op == "sym":
            return self.world.value_of(*args)
        if op == "cell":
            of, bits = args
            if (of, bits) not in self.world.sets[of]:
                raise Refused(f"there is no cell {bits!a} of {of!a}")
            return (of, bits)
        if op in ("field", "next", "apply"):
            return self._looked_up(op, args, env)
        return self._number(op, args, env)

    def _param(self, name: str) -> Fraction:
        if name not in self.world.params:
            raise Beyond("params beside rules and relations")
        return self.world.params[name]

    def _looked_up(self, op: str, args: list[Json], env: Env) -> Any:
        of, a = args if op != "field" else args[::-1]
        value = self.value(a, env)
        if value is None:
            return None
        if op == "field":
            return self.world.fields[value, of]
        if op == "next":
            return self.world.step(of, value)[0]
        found = self.world.images(of).get(value, set())
        return next(iter(found)) if len(found) == 1 else None

    def _number(self, op: str, args: list[Json], env: Env) -> Fraction | None:
        """Exact arithmetic; None where an operand is undefined or a divisor is 0."""
        if op == "scale" and args[1] == 0:
            op, args = "*", [args[0], args[2]]
        if op not in ARITHMETIC or not args:
            raise Beyond(f"`{op!s:.20}` in a goal about rules and relations")
        given = [self.value(a, env) for a in args]
        if not all(v is None or isinstance(v, Fraction) for v in given):
            raise Refused("arithmetic with something that is no number")
        return None if None in given else ARITHMETIC[op](*given)


def _short(q: Fraction) -> Fraction:
    if q.numerator.bit_length() + q.denominator.bit_length() > MAX_BITS:
        raise Beyond("a number is too long")
    return q


def _power(a: Fraction, k: Fraction) -> Fraction | None:
    length = a.numerator.bit_length() + a.denominator.bit_length()
    if k.denominator != 1 or abs(k) * length > MAX_BITS:
        raise Beyond("a power with no integer, or a large one, as exponent")
    return None if a == 0 and k < 0 else Fraction(a ** int(k))


def _folded(step: Callable[[Fraction, Fraction], Fraction]) -> Callable[..., Fraction]:
    return lambda *given: reduce(lambda a, b: _short(step(a, b)), given)


ARITHMETIC: dict[str, Callable[..., Fraction | None]] = {
    "+": _folded(lambda a, b: a + b), "*": _folded(lambda a, b: a * b), "-": lambda a, b: _short(a - b),
    "neg": lambda a: -a, "/": lambda a, b: _short(a / b) if b else None, "^": _power, "abs": abs,
    "min": lambda *v: min(v), "max": lambda *v: max(v), "clamp": lambda x, low, high: min(max(x, low), high),
}  # fmt: skip


def _masks(truths: list[Truth]) -> Masks:
    spend(len(truths))
    digits = [("1" if t is True else "0", "1" if t is False else "0") for t in reversed(truths)]
    return int("".join(d for d, _ in digits) or "0", 2), int("".join(d for _, d in digits) or "0", 2)


def _joined(op: str, masks: list[Masks]) -> Masks:
    """A connective, cell by cell."""
    if op == "not":
        ((yes, no),) = masks
        return no, yes
    if op == "implies":
        (yes, no), (then, other) = masks
        return no | then, yes & other
    yes, no = masks[0]
    for y, n in masks[1:]:
        yes, no = (yes & y, no | n) if op == "and" else (yes | y, no & n)
    return yes, no


def _decided(kind: str, yes: int, no: int, count: int) -> Truth:
    """A quantifier from the cells where its body holds and those where it does not."""
    everywhere = (1 << count) - 1
    if kind == "forall":
        return False if no else True if yes == everywhere else None
    if kind == "exists":
        return True if yes else False if no == everywhere else None
    several = yes.bit_count() > 1
    return False if several or no == everywhere else True if yes and yes | no == everywhere else None
