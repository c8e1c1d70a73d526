"""Functions of the state as names with derivatives (docs/core.md section 9, "Names")."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from math import factorial, isqrt

from haverify.maths.polynomial import NOUGHT, Monomial, Polynomial, constant, total, variable
from haverify.obligations.formula import Formula, compare, conjunction, disjunction
from haverify.text.record import field, holder

ONE = constant(1)
WAVES, SERIES, PARTIAL = ("sin", "cos"), ("sin", "cos", "exp"), ("log", "sqrt", "inv")


def factors(m: Monomial) -> tuple[str, ...]:
    """The names of a monomial, each as often as its exponent says."""
    return tuple(v for v, e in m for _ in range(e))


def _exactly(op: str, q: Fraction | None) -> Fraction | None:
    """A root, a logarithm or an inverse of a number, where that is a rational seen at once."""
    if q is None or q <= 0:
        return None
    if op == "sqrt":
        root = Fraction(isqrt(q.numerator), isqrt(q.denominator))
        return root if root * root == q else None
    return 1 / q if op == "inv" else Fraction(0) if op == "log" and q == 1 else None


@holder
class Functions:
    """The functions met so far, by name: `sin`, `cos`, `exp`, `log`, `sqrt` or `inv` (1 over it), and the argument.

    Where a logarithm, a root or an inverse is not defined, nothing is known of it.
    """

    known: dict[str, tuple[str, Polynomial]] = field(default_factory=dict)

    def apply(self, op: str, a: Polynomial) -> Polynomial:
        """`op(a)` as a polynomial in names; odd and even functions of `-a` are those of `a`."""
        if not a.whole and op not in ("log", "inv"):
            return NOUGHT if op in ("sin", "sqrt") else ONE
        exact = _exactly(op, a.constant)
        if exact is not None:
            return constant(exact)
        by_names = {factors(m): c for m, c in a.terms.items()}
        is_turned = op in WAVES and by_names[min(by_names)] < 0
        if is_turned:
            a, by_names = -a, {m: -c for m, c in by_names.items()}
        text = "+".join("*".join([str(by_names[m]), *m]) for m in sorted(by_names))
        for each in WAVES if op in WAVES else (op,):
            self.known[f"{each}({text})"] = (each, a)
        found = variable(f"{op}({text})")
        return -found if is_turned and op == "sin" else found

    def support(self, names: Iterable[str]) -> Iterator[str]:
        """The names that names stand for: themselves, or what the argument of a function is made of."""
        for n in names:
            if n in self.known:
                yield from self.support(self.known[n][1].variables)
            else:
                yield n

    def substitute(self, p: Polynomial, values: Mapping[str, Polynomial]) -> Polynomial:
        """`p` with names replaced at once, also inside of functions."""
        inner = {n: self.known[n] for n in p.variables if n in self.known and set(values) & set(self.support([n]))}
        images = {n: self.apply(op, self.substitute(a, values)) for n, (op, a) in inner.items()}
        return p.substitute({**values, **images})

    def derivative(self, p: Polynomial, rates: Mapping[str, Polynomial]) -> Polynomial:
        """The derivative of `p` along a flow; names without a rate are constant."""
        return total([NOUGHT, *(p.derivative(n) * self._rate(n, rates) for n in p.variables)])

    def _rate(self, name: str, rates: Mapping[str, Polynomial]) -> Polynomial:
        if name not in self.known:
            return rates.get(name, NOUGHT)
        op, a = self.known[name]
        inner = self.derivative(a, rates)
        if op == "sqrt":
            return self.apply("inv", variable(name)).scaled(Fraction(1, 2)) * inner
        if op in ("log", "inv"):
            inverse = self.apply("inv", a)
            return (inverse if op == "log" else -(inverse**2)) * inner
        outer = {"sin": "cos", "cos": "sin", "exp": "exp"}[op]
        slope = self.apply(outer, a) * inner
        return -slope if op == "cos" else slope

    def partial(self, p: Polynomial) -> Iterator[tuple[str, Polynomial]]:
        """Functions in a polynomial that are not defined everywhere, with their arguments; also inside of others."""
        for op, a in (self.known[n] for n in p.variables if n in self.known):
            yield from self.partial(a)
            if op in PARTIAL:
                yield op, a

    def meaning(self, name: str) -> Formula:
        """What holds of a root, a logarithm or an inverse: that it is not defined, or what it is."""
        op, a = self.known[name]
        value = variable(name)
        if op == "inv":
            return disjunction([compare("==", a), compare("==", value * a - ONE)])
        if op == "log":
            return disjunction([compare("<=", a), compare("<=", value - a + ONE)])
        told = conjunction([compare("==", value**2 - a), compare(">=", value)])
        return disjunction([compare("<", a), told])

    def series(self, name: str, terms: int) -> Formula:
        """The bound of a function by the first terms of its series; of a sine, times its argument."""
        op, a = self.known[name]
        odd = op == "sin"
        powers = range(terms) if op == "exp" else range(odd, 2 * terms + odd, 2)
        signs = {k: 1 if op == "exp" else (-1) ** (k // 2) for k in powers}
        partial = total([NOUGHT, *((a ** (k + odd)).scaled(Fraction(s, factorial(k))) for k, s in signs.items())])
        value = variable(name) * a if odd else variable(name)
        return compare("<=" if op != "exp" and terms % 2 else ">=", value - partial)
