"""Why a flow keeps a formula: a FLOW of docs/core.md section 9, its cuts the literals of the formula in some order."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from haverify.analyses.induction.prove import prove, rule_for
from haverify.analyses.induction.refute import Effort, refute
from haverify.maths.polynomial import NOUGHT, Polynomial
from haverify.obligations.formula import Formula, Junction, Literal, compare, conjunction, literal, literals, negation
from haverify.obligations.functions import Functions, factors
from haverify.obligations.premises import Premises, formula_json, members, polynomial_json, primitive, whole
from haverify.text.record import holder

Json = Any
Rates = dict[str, Polynomial]
MOST_BRANCHES = 8
COFACTORS = (Fraction(0), Fraction(1), Fraction(-1))


@holder
class Keeper:
    """One mode: the rates of its flow, and the effort for each question. `open` collects what no rule shows."""

    rates: Rates
    effort: Effort
    functions: Functions
    open: list[Formula]
    has_inputs: bool = False  # which need have no derivative

    def flow(self, always: Premises, formula: Formula) -> Json | None:
        """A proof that runs with `always` at all times keep the formula."""
        formula = primitive(formula)
        if not self._is_defined(always, formula):
            return None
        branches = members(formula, is_and=False)
        if len(branches) > MOST_BRANCHES:
            return None
        found: Json = self._branch(always, [formula, *map(negation, branches)], False, formula)
        for k, branch in reversed(list(enumerate(branches))):
            start = [formula, *map(negation, branches[:k]), branch]
            proof = self._branch(always, start, branch, formula)
            if proof is None:
                return None
            found = ["split", formula_json(branch), proof, found] if len(branches) > 1 else proof
        return found

    def _is_defined(self, always: Premises, formula: Formula) -> bool:
        """Whether roots, logarithms and inverses that are derived, or are rates, are away from where they are not."""
        read = [compare("<=", p) for f in literals(formula) for _, p in self.functions.partial(f.polynomial)]
        for rate in self.rates.values():
            read += [compare("<" if op == "sqrt" else "<=", a) for op, a in self.functions.partial(rate)]
        return all(refute(always.with_(wrong), Effort(8, 8)) is not None for wrong in dict.fromkeys(read))

    def _branch(self, always: Premises, start: list[Formula], kept: Formula, wanted: Formula) -> Json | None:
        """A proof that runs that begin with `start` keep a conjunction, which gives what is wanted."""
        waiting = [g for f in members(kept, is_and=True) for g in self._apart(f)]
        cuts, known = list[Json](), always
        while waiting:
            done = next(((f, rule) for f in waiting if (rule := self._rule(known, f)) is not None), None)
            if done is None:
                done = self._at_rest(known, waiting) or self._together(known, waiting)
            if done is None:
                self.open.extend(waiting)
                return None
            f, rule = done
            cut = self._cut(known, start, f, rule)
            if cut is None:
                return None
            cuts.append(cut)
            known = known.with_(f)
            waiting = [g for g in waiting if g not in members(f, is_and=True)]
        end = prove(known.with_(negation(wanted)), self.effort)
        return None if end is None else {"cuts": cuts, "end": end}

    def _apart(self, f: Formula) -> list[Formula]:
        """An equation whose slope has inverses in it as two inequalities."""
        if isinstance(f, Literal) and f.op == "==" and any(self.functions.partial(self._slope(f.polynomial))):
            return [compare("<=", f.polynomial), compare(">=", f.polynomial)]
        return [f]

    def _cut(self, known: Premises, start: list[Formula], f: Formula, rule: Json) -> Json | None:
        begins = "t" if rule and rule["rule"] == "always" else prove(known.with_(*start, negation(f)), self.effort)
        return None if begins is None else {"formula": formula_json(f), "start": begins, "keep": rule}

    def _rule(self, known: Premises, f: Formula) -> Json | None:
        """A rule for one literal, or for a formula that follows from what is known."""
        proof = refute(known.with_(negation(f)), Effort(8, 8))
        if proof is not None:
            return {"rule": "always", "proof": proof}
        if not isinstance(f, Literal):
            return self._still(f)
        found = self._darboux(f) or self._growth(known, f) or self._barrier(known, f)
        found = found or rule_for(known, literal(f.op, whole(f.polynomial)), self.rates, self.effort)
        return None if found is not None and found["rule"] == "lie" and self.has_inputs else found

    def _slope(self, p: Polynomial) -> Polynomial:
        return self.functions.derivative(p, self.rates)

    def _darboux(self, f: Literal) -> Json | None:
        """The slope is a multiple of the polynomial."""
        p = whole(f.polynomial)
        cofactor = divided(self._slope(p), p)
        if cofactor is None:
            return None
        return {"rule": "darboux", "matrix": [[polynomial_json(cofactor)]], "ideal": [[]]}

    def _growth(self, known: Premises, f: Literal) -> Json | None:
        """Near the boundary the polynomial does not grow."""
        if f.op not in ("<", "<="):
            return None
        p = whole(f.polynomial)
        side = compare(">" if f.op == "<=" else "<", p)
        for c in (self.rates["time"].scaled(k) for k in COFACTORS):
            proof = refute(known.with_(side, compare(">", self._slope(p) - c * p)), self.effort)
            if proof is not None:
                return {"rule": "growth", "cofactor": polynomial_json(c), "band": None, "proof": proof}
        return None

    def _barrier(self, known: Premises, f: Literal) -> Json | None:
        found = self._together(known, [f]) if f.op in ("<", "<=") else None
        return None if found is None else found[1]

    def _together(self, known: Premises, found: list[Formula]) -> tuple[Formula, Json] | None:
        """On the boundary of each, the others holding, it decreases."""
        if not all(isinstance(f, Literal) and f.op in ("<", "<=") for f in found):
            return None
        leaves = [literal(f.op, whole(f.polynomial)) for f in found if isinstance(f, Literal)]
        proofs = []
        for j, f in enumerate(leaves):
            assert isinstance(f, Literal)
            p = f.polynomial
            others = [compare("<=", g.polynomial) for i, g in enumerate(leaves) if i != j and isinstance(g, Literal)]
            proof = prove(known.with_(*others, compare("==", p), compare(">=", self._slope(p))), self.effort)
            if proof is None:
                return None
            proofs.append(proof)
        kept = leaves[0] if len(leaves) == 1 else Junction(True, tuple(leaves))  # type: ignore[arg-type]
        return kept, {"rule": "barrier", "proofs": proofs}

    def _at_rest(self, known: Premises, found: list[Formula]) -> tuple[Formula, Json] | None:
        """Variables have values where none of them moves, and nothing else moves them."""
        given = [(f, v) for f in found if isinstance(f, Literal) and (v := self._placed(f)) is not None]
        rates = [self.rates[v] for _, v in given]
        read = set(self.functions.support(n for p in rates for n in p.variables))
        if not given or not read & self.rates.keys() <= {v for _, v in given}:
            return None
        cut = conjunction([f for f, _ in given])
        proofs = [prove(known.with_(cut, compare("!=", p)), self.effort) for p in rates]
        return None if None in proofs else (cut, {"rule": "rest", "proofs": proofs})

    def _placed(self, f: Literal) -> str | None:
        """The variable that an equation gives the value of, by what does not move."""
        p = f.polynomial
        moving = set(self.functions.support(p.variables)) & self.rates.keys()
        (v,) = moving if len(moving) == 1 and f.op == "==" else (None,)
        alone = [m for m in p.terms if v in dict(m)]
        return (
            v
            if v is not None and v != "time" and alone == [((v, 1),)] and v not in _inside(p, self.functions)
            else None
        )

    def _still(self, f: Formula) -> Json | None:
        """All polynomials of the formula are constant along the flow."""
        found = list(dict.fromkeys(whole(leaf.polynomial) for leaf in literals(f)))
        if self.has_inputs or any(self._slope(p).whole for p in found):
            return None
        return {"rule": "lie", "ranks": [[1, [[]], []] for _ in found], "forward": "t", "backward": "t"}


def _inside(p: Polynomial, functions: Functions) -> set[str]:
    """What the functions in a polynomial read."""
    return {w for n in p.variables if n in functions.known for w in functions.support([n])}


def divided(p: Polynomial, d: Polynomial) -> Polynomial | None:
    """`p / d` where that is a polynomial."""
    lead = max(d.whole, key=factors_order)
    quotient, rest = NOUGHT, p
    while rest.whole:
        top = max(rest.whole, key=factors_order)
        m = _over(dict(top), dict(lead))
        if m is None:
            return None
        term = Polynomial({m: 1}).scaled(rest.terms[top] / d.terms[lead])
        quotient, rest = quotient + term, rest - term * d
    return quotient


def factors_order(m: Any) -> tuple[int, tuple[str, ...]]:
    """A degree order, in which a product has the product of the greatest terms as its greatest."""
    return sum(e for _, e in m), tuple(sorted(factors(m), reverse=True))


def _over(m: dict[str, int], d: dict[str, int]) -> Any:
    left = {v: m.get(v, 0) - e for v, e in {**dict.fromkeys(m, 0), **d}.items()}
    return None if any(e < 0 for e in left.values()) else tuple(sorted((v, e) for v, e in left.items() if e))
