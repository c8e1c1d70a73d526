"""Premises that have no common point, and what shows it (docs/core.md section 9, "Proofs")."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from math import gcd
from typing import Any

from hacheck import bernstein
from hacheck.formula import Formula, conj, disj, literal, literals, members, negated, replace, sign_fits
from hacheck.functions import Functions
from hacheck.polynomial import (
    ONE,
    ZERO,
    Env,
    Poly,
    add,
    by_power,
    const,
    constant,
    mul,
    names,
    power,
    scale,
    total,
    var,
)
from hacheck.rational import PI, Refused, number, spend

Json = Any
LITERALS = ("<", "<=", "==", "!=")


def polynomial(value: Json) -> Poly:
    """A POLY of a certificate: a list of terms, each a rational and names."""
    if not isinstance(value, list) or not all(isinstance(t, list) and t for t in value):
        raise Refused("a polynomial is malformed")
    if not all(isinstance(n, str) for t in value for n in t[1:]):
        raise Refused("a polynomial has a factor that is no name")
    out = []
    for t in value:
        p = const(number(t[0]))
        for n in t[1:]:
            p = mul(p, var(n))
        out.append((1, p))
    return total(out)


def formula(value: Json) -> Formula:
    """A FORMULA of a certificate."""
    spend(5)
    if isinstance(value, bool):
        return value
    if not isinstance(value, list) or not value:
        raise Refused("a formula is malformed")
    if value[0] in ("and", "or"):
        return (conj if value[0] == "and" else disj)(formula(f) for f in value[1:])
    if value[0] not in LITERALS or len(value) != 2:
        raise Refused("a formula is malformed")
    return literal(value[0], polynomial(value[1]))


def primitive(op: str, p: Poly) -> Formula:
    """The literal with coprime integer coefficients."""
    common = gcd(*p.terms.values()) if p.terms else 1
    return literal(op, Poly({m: c // common for m, c in p.terms.items()}, 1, p.bits))


class Premises:
    """What is assumed: a list of formulas, none a conjunction, none twice; entries are only ever added at the end."""

    def __init__(self, functions: Functions, entries: Iterable[Formula] = ()) -> None:
        self.functions, self.entries = functions, list[Formula]()
        self._seen = set[Any]()
        self._add(entries)

    def _add(self, formulas: Iterable[Formula]) -> None:
        for f in formulas:
            for g in members(_distinct(replace(f, primitive)), "and"):
                key = _key(g)
                if g is not True and key not in self._seen and not _is_always(g):
                    self._seen.add(key)
                    self.entries.append(g)

    def with_(self, *formulas: Formula) -> Premises:
        """These and more."""
        spend(10 + len(self.entries))
        out = Premises(self.functions)
        out.entries, out._seen = list(self.entries), set(self._seen)
        out._add(formulas)
        return out

    def at(self, i: Json) -> Formula:
        """Entry number i."""
        if type(i) is not int or not 0 <= i < len(self.entries):
            raise Refused("a proof speaks of a premise that is not there")
        return self.entries[i]

    def equation(self, i: Json) -> Poly:
        """The polynomial that entry i says is 0."""
        f = self.at(i)
        if isinstance(f, bool) or f[0] != "==":
            raise Refused("a proof takes a premise for an equation that is none")
        return f[1]  # type: ignore[no-any-return]

    def nonnegative(self, i: Json) -> Poly:
        """The polynomial that entry i says is at least 0."""
        f = self.at(i)
        if isinstance(f, bool) or f[0] not in ("<", "<="):
            raise Refused("a proof takes a premise for an inequality that is none")
        return scale(f[1], -1)

    def positive(self, i: Json) -> Poly:
        """A polynomial that entry i says is above 0."""
        f = self.at(i)
        if isinstance(f, bool) or f[0] not in ("<", "!="):
            raise Refused("a proof takes a premise for a strict one that is none")
        return scale(f[1], -1) if f[0] == "<" else power(f[1], 2)

    def mapped(self, env: Env) -> Premises:
        """All entries with names replaced; they keep their places."""
        out = Premises(self.functions)
        put = self.functions.substitute
        new = (replace(replace(f, lambda op, p: literal(op, put(p, env))), primitive) for f in self.entries)
        out.entries = [_distinct(f) for f in new]
        out._seen = set(map(_key, out.entries))
        return out


def _is_always(f: Formula) -> bool:
    """Is it a disjunction of a literal and its negation, and of few others?"""
    if isinstance(f, bool) or f[0] != "or" or len(f) > 9:
        return False
    keys = {_key(m) for m in f[1:] if m[0] in LITERALS}
    return any(_key(replace(negated(m), primitive)) in keys for m in f[1:] if m[0] in LITERALS)


def _distinct(f: Formula) -> Formula:
    """The formula without members that are there already."""
    if isinstance(f, bool) or f[0] in LITERALS:
        return f
    found: dict[Any, Formula] = {}
    for g in map(_distinct, f[1:]):
        found.setdefault(_key(g), g)
    return (conj if f[0] == "and" else disj)(found.values())


def _key(f: Formula) -> Any:
    if isinstance(f, bool):
        return f
    if f[0] in ("and", "or"):
        return f[0], *map(_key, f[1:])
    return f[0], frozenset(f[1].terms.items()), f[1].unit


def refute(proof: Json, known: Premises) -> None:
    """Refuse unless the proof shows that the premises have no common point."""
    spend(20)
    if proof == "t":
        if not _absurd(known.entries):
            raise Refused("premises do not exclude each other as they stand")
    elif proof == "b":
        if not on_box(known):
            raise Refused("premises are not seen to exclude each other on their box")
    elif not isinstance(proof, list) or not proof or (proof[0], len(proof)) not in _STEPS:
        raise Refused("a proof is malformed")
    else:
        _STEPS[proof[0], len(proof)](known, *proof[1:])


def _absurd(entries: list[Formula]) -> bool:
    """Is an entry false when literals count as false that exclude another entry?"""
    left: dict[Any, set[int]] = {}

    def signs(op: str, p: Poly) -> tuple[Any, set[int]]:
        flip = -1 if p.terms and p.terms[min(p.terms)] < 0 else 1
        key = frozenset((m, flip * c) for m, c in p.terms.items())
        return key, {flip * s for s in (-1, 0, 1) if sign_fits(op, s)}

    for f in entries:
        if not isinstance(f, bool) and f[0] in LITERALS:
            key, allowed = signs(*f)
            left[key] = left.get(key, {-1, 0, 1}) & allowed

    def possible(op: str, p: Poly) -> Formula:
        key, allowed = signs(op, p)
        return bool(left.get(key, {-1, 0, 1}) & allowed)

    spend(sum(1 for f in entries for _ in literals(f)))
    return any(replace(f, possible) is False for f in entries)


def on_box(known: Premises) -> bool:
    """Is there no common point on the box that the premises leave, functions being enclosed on it?"""
    f = disj(map(negated, known.entries))
    found = set(_names(known.entries))
    box: bernstein.Box = {**dict.fromkeys(known.functions.support(found), bernstein.FREE), "pi": PI}
    box.update(dict.fromkeys(found - box.keys(), bernstein.FREE))
    for _ in range(3):
        small = bernstein.narrowed(f, box)
        small = None if small is None else known.functions.enclosed(small, found)
        if small is None:
            return True
        if small == box:
            break
        box = small
    return bernstein.shown(f, box)


def _names(entries: Iterable[Formula]) -> Iterator[str]:
    return (n for f in entries for _, p in literals(f) for n in names(p))


def _psatz(known: Premises, squares: Json, equal: Json, strict: Json) -> None:
    """An identity that says 0 > 0."""
    summands = []
    for sos, factors in squares:
        p = _sum_of_squares(sos)
        for i in factors:
            p = mul(p, known.nonnegative(i))
        summands.append((1, p))
    summands += [(1, mul(polynomial(p), known.equation(i))) for i, p in equal]
    q, factors = strict
    if number(q) <= 0:
        raise Refused("what should be above 0 has a factor that is not")
    p = const(number(q))
    for i in factors:
        p = mul(p, known.positive(i))
    if total([*summands, (1, p)]) != ZERO:
        raise Refused("a sum that should be 0 is not")


def _sum_of_squares(value: Json) -> Poly:
    pairs = [[value, None]] if isinstance(value, str) else value
    out = []
    for q, root in pairs:
        if number(q) < 0:
            raise Refused("a square has a factor below 0")
        out.append((1, scale(ONE if root is None else power(polynomial(root), 2), number(q))))
    return total(out)


def _or(known: Premises, i: Json, proofs: Json) -> None:
    cases = members(known.at(i), "or")
    if not isinstance(proofs, list) or len(proofs) != len(cases):
        raise Refused("a disjunction has another number of cases")
    for case, proof in zip(cases, proofs, strict=True):
        refute(proof, known.with_(case))


def _cut(known: Premises, value: Json, yes: Json, no: Json) -> None:
    f = formula(value)
    refute(yes, known.with_(f))
    refute(no, known.with_(negated(f)))


def _split(known: Premises, name: Json, q: Json, low: Json, high: Json) -> None:
    if not isinstance(name, str):
        raise Refused("a split names no variable")
    p = add(var(name), const(number(q)), -1)
    refute(low, known.with_(literal("<=", p)))
    refute(high, known.with_(literal(">=", p)))


def _put(known: Premises, i: Json, name: Json, proof: Json) -> None:
    """Replace a variable by what an equation says it is."""
    if not isinstance(name, str) or name in known.functions.known:
        raise Refused("only a variable can be replaced")
    parts = by_power(known.equation(i), name)
    rest, a = parts.get(0, ZERO), constant(parts.get(1, ZERO))
    if not a or not parts.keys() <= {0, 1} or name in known.functions.support(names(rest)):
        raise Refused("an equation does not say what a variable is")
    refute(proof, known.mapped(Env({name: scale(rest, -1 / a)})))


def _fact(known: Premises, kind: Json, *rest: Json) -> None:
    """Add what holds of pi and functions everywhere."""
    *about, proof = rest
    f = known.functions
    if kind == "pi" and not about:
        new: list[Formula] = [
            literal(">=", add(var("pi"), const(PI[0]), -1)),
            literal("<=", add(var("pi"), const(PI[1]), -1)),
        ]
    elif kind == "circle" and len(about) == 1:
        new = [literal("==", f.circle(about[0]))]
    elif kind == "positive" and len(about) == 1:
        new = [literal(">", f.positive(about[0]))]
    elif kind == "meaning" and len(about) == 1:
        nowhere, found = f.meaning(about[0])
        new = [disj([literal(*nowhere), conj(literal(*q) for q in found)])]
    elif kind == "series" and len(about) == 2:
        new = [literal(*f.series(*about))]
    else:
        raise Refused("there is no such fact")
    refute(proof, known.with_(*new))


_STEPS: dict[tuple[Any, int], Any] = {
    ("psatz", 4): _psatz, ("or", 3): _or, ("cut", 4): _cut, ("s", 5): _split, ("put", 4): _put,
    ("fact", 3): _fact, ("fact", 4): _fact, ("fact", 5): _fact,
}  # fmt: skip
