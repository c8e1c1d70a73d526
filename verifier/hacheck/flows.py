"""Formulas that a flow keeps (docs/core.md section 9): a list of cuts, each shown by a rule with those before it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from hacheck.formula import Formula, conj, disj, literal, literals, members, negated, replace
from hacheck.polynomial import ZERO, Poly, add, by_power, const, constant, mul, total
from hacheck.positivity import Premises, formula, on_box, polynomial, primitive, refute
from hacheck.rational import Beyond, Refused, number

Json = Any
MAX_RANK = 12


class Flow:
    """One mode: what is known at all times there, and the rates of its variables."""

    def __init__(self, always: Premises, rates: dict[str, Poly], names: set[str], has_inputs: bool = False) -> None:
        self.always, self.rates, self.names, self.has_inputs = always, rates, names, has_inputs
        self._seen = set[Any]()

    def given(self, value: Json) -> Formula:
        """A formula of a certificate about the state, its literals primitive."""
        f = replace(formula(value), primitive)
        read = {n for _, p in literals(f) for n in p_names(p)}
        self.always.functions.of_numbers(read)
        if not set(self.always.functions.support(read)) <= self.names:
            raise Refused("a formula about the state reads another name")
        return f

    def kept(self, proof: Json, at_start: list[Formula], wanted: Formula) -> None:
        """Refuse unless every run from a state with `at_start` has `wanted` at all times in the mode."""
        self.slope(ZERO)  # rates are defined, whatever is shown of them
        if isinstance(proof, list):
            word, value, yes, no = proof
            if word != "split":
                raise Refused("a proof about a flow is malformed")
            f = self.given(value)
            self.kept(yes, [*at_start, f], wanted)
            self.kept(no, [*at_start, negated(f)], wanted)
            return
        known = self.always
        for cut in proof["cuts"]:
            f, keep = self.given(cut["formula"]), cut["keep"]
            if keep is not None and keep["rule"] == "always":
                refute(keep["proof"], known.with_(negated(f)))
            else:
                refute(cut["start"], known.with_(*at_start, negated(f)))
                if f is not False:  # else no run begins so
                    self._rule(known, f, keep)
            known = known.with_(f)
        refute(proof["end"], known.with_(negated(wanted)))

    def _rule(self, known: Premises, f: Formula, keep: Json) -> None:
        if isinstance(f, bool):
            raise Refused("a cut that is no formula")
        if keep["rule"] not in _RULES:
            raise Beyond("a rule about flows that this checker does not have")
        _RULES[keep["rule"]](self, known, f, keep)

    def slope(self, p: Poly) -> Poly:
        """The derivative along the flow, which is there where no function is at the end of where it is defined."""
        self._defined(p, "<=")
        for rate in self.rates.values():
            self._defined(rate, "<")
        return self.always.functions.derivative(p, self.rates)

    def _defined(self, p: Poly, wrong: str) -> None:
        """Refuse unless arguments are above 0 throughout (roots, with `<`: not below 0; inverses: not 0)."""
        for op, a in self.always.functions.partial(p):
            key = op, _hashable(a), wrong
            if key not in self._seen:
                ops = ["<=", ">="] if op == "inv" else [wrong if op == "sqrt" else "<="]
                if not any(on_box(self.always.with_(literal(o, a))) for o in ops):
                    raise Refused(f"a flow where `{op}` is not defined everywhere")
                self._seen.add(key)

    def _cofactor(self, value: Json) -> Poly:
        """What a polynomial grows by, which has to be bounded: no function in it grows beyond all bounds."""
        p = polynomial(value)
        self._defined(p, "<")
        return p

    def _ideal(self, known: Premises, value: Json) -> Poly:
        """A combination of equations that hold at all times."""
        return total((1, mul(polynomial(p), known.equation(i))) for i, p in value)

    def darboux(self, known: Premises, f: Formula, keep: Json) -> None:
        """The slopes are linear in the polynomials themselves: what is 0 stays 0, and one alone keeps its sign."""
        found = members(f, "and")
        if len(found) > 1 and any(g[0] != "==" for g in found):
            raise Refused("several polynomials keep their signs together only as equations")
        if any(g[0] in ("and", "or") for g in found) or not len(found) == len(keep["matrix"]) == len(keep["ideal"]):
            raise Refused("a row is missing, or a cut is of another shape than its rule")
        for (_, p), row, ideal in zip(found, keep["matrix"], keep["ideal"], strict=True):
            terms = [(1, mul(self._cofactor(c), g[1])) for c, g in zip(row, found, strict=True)]
            if total([*terms, (1, self._ideal(known, ideal)), (-1, self.slope(p))]) != ZERO:
                raise Refused("a slope is not what its row says")

    def growth(self, known: Premises, f: Formula, keep: Json) -> None:
        """Near the boundary `p' <= c p`, on the side where that keeps p from becoming or being above 0."""
        if f[0] not in ("<", "<="):
            raise Refused("a cut is of another shape than its rule")
        p, side = f[1], (">" if f[0] == "<=" else "<")
        near = [literal(side, p)]
        if keep["band"] is not None:
            width = number(keep["band"])
            if width <= 0:
                raise Refused("a band without a width")
            near.append(literal("<", add(p, const(width), -1)) if f[0] == "<=" else literal(">", add(p, const(width))))
        faster = literal(">", add(self.slope(p), mul(self._cofactor(keep["cofactor"]), p), -1))
        refute(keep["proof"], known.with_(*near, faster))

    def barrier(self, known: Premises, f: Formula, keep: Json) -> None:
        """On the boundary of each literal, the others holding at least as closed ones, its slope leads inwards."""
        found = members(f, "and")
        if any(g[0] not in ("<", "<=") for g in found) or len(keep["proofs"]) != len(found):
            raise Refused("a cut is of another shape than its rule")
        for j, ((_, p), proof) in enumerate(zip(found, keep["proofs"], strict=True)):
            others = [literal("<=", g[1]) for i, g in enumerate(found) if i != j]
            refute(proof, known.with_(*others, literal("==", p), literal(">=", self.slope(p))))

    def rest(self, known: Premises, f: Formula, keep: Json) -> None:
        """Variables that nothing else moves are where none of them moves: their rates being smooth, they stay there."""
        found = [self._placed(g) for g in members(f, "and")]
        still, rates = set(found), [self.rates[v] for v in found]
        read = set(self.always.functions.support(n for p in rates for n in p_names(p)))
        if not read & self.rates.keys() <= still or len(keep["proofs"]) != len(rates):
            raise Refused("what is said to be at rest is moved by something else")
        for p, proof in zip(rates, keep["proofs"], strict=True):
            self.slope(p)  # is there
            refute(proof, known.with_(f, literal("!=", p)))

    def _placed(self, g: Formula) -> str:
        """The variable that an equation gives the value of, by what does not move."""
        if g[0] == "==":
            for v in sorted(self.rates.keys() & set(p_names(g[1])) - {"time"}):
                parts = by_power(g[1], v)
                rest = set(self.always.functions.support(p_names(parts.get(0, ZERO))))
                if parts.keys() <= {0, 1} and constant(parts[1]) and not rest & self.rates.keys():
                    return v
        raise Refused("a cut is of another shape than its rule")

    def lie(self, known: Premises, f: Formula, keep: Json) -> None:
        """What holds now holds for a while, and what held for a while holds now, as derivatives tell."""
        if self.has_inputs:  # which need have no derivative
            raise Refused("derivatives of inputs")
        ordered = list(dict.fromkeys(_hashable(p) for _, p in literals(f)))
        if len(ordered) != len(keep["ranks"]):
            raise Refused("a rank is missing")
        first = {_hashable(p): p for _, p in literals(f)}
        chains = {}
        for key, (rank, row, ideal) in zip(ordered, keep["ranks"], strict=True):
            chains[key] = self._chain(known, first[key], rank, row, ideal), row is not None
        soon = replace(f, lambda op, p: _soon(op, *chains[_hashable(p)]))
        before = replace(f, lambda op, p: _before(op, *chains[_hashable(p)]))
        refute(keep["forward"], known.with_(f, negated(soon)))
        refute(keep["backward"], known.with_(negated(f), before))

    def _chain(self, known: Premises, p: Poly, rank: Json, row: Json, ideal: Json) -> list[Poly]:
        """p and its derivatives below the rank; with a row the next one is a combination of them."""
        if type(rank) is not int or not 1 <= rank <= MAX_RANK or (row is not None and len(row) != rank):
            raise Refused("a rank is out of range")
        chain = [p]
        for _ in range(rank):
            chain.append(self.slope(chain[-1]))
        if row is not None:
            terms = [(1, mul(self._cofactor(c), q)) for c, q in zip(row, chain, strict=False)]
            if total([*terms, (1, self._ideal(known, ideal)), (-1, chain[rank])]) != ZERO:
                raise Refused("a derivative is not what its row says")
        return chain[:rank]


_RULES: dict[Any, Any] = {
    "darboux": Flow.darboux, "growth": Flow.growth, "barrier": Flow.barrier, "rest": Flow.rest, "lie": Flow.lie,
}  # fmt: skip


def p_names(p: Poly) -> Iterator[str]:
    """The names in a polynomial."""
    return (n for m in p.terms for n in m)


def _hashable(p: Poly) -> Any:
    return frozenset(p.terms.items())


def _first(op: str, chain: list[Poly]) -> list[Formula]:
    """For each k: the derivatives before the k-th are 0, and it compares with 0."""
    zeros = [literal("==", p) for p in chain]
    return [conj([*zeros[:k], literal(op, p)]) for k, p in enumerate(chain)]


def _zero(chain: list[Poly]) -> Formula:
    return conj(literal("==", p) for p in chain)


def _soon(op: str, chain: list[Poly], closed: bool) -> Formula:
    """Only where this holds: `p op 0` at all times right after."""
    if op == "==":
        return _zero(chain) if closed else False
    if op == "!=":
        return disj(literal("!=", p) for p in chain)
    return disj([*_first("<", chain), op == "<=" and closed and _zero(chain)])


def _before(op: str, chain: list[Poly], closed: bool) -> Formula:
    """Wherever `p op 0` at instants arbitrarily shortly before, this holds."""
    backwards = [p if k % 2 == 0 else _minus(p) for k, p in enumerate(chain)]
    if op == "==":
        return _zero(chain)
    if op == "!=":
        return disj(literal("!=", p) for p in chain) if closed else True
    return disj([*_first("<", backwards), (op == "<=" or not closed) and _zero(chain)])


def _minus(p: Poly) -> Poly:
    return add(ZERO, p, -1)
