"""Functions of the state: each is a name, with a derivative, bounds for all arguments and an enclosure on a box."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from fractions import Fraction
from math import ceil, factorial, floor, isqrt

from hacheck.bernstein import FREE, Box, bounds, meet
from hacheck.elementary import logarithm
from hacheck.polynomial import (
    ONE,
    ZERO,
    Env,
    Poly,
    add,
    const,
    constant,
    mul,
    names,
    power,
    scale,
    substitute,
    total,
    var,
)
from hacheck.polynomial import derivative as partial
from hacheck.rational import PI, Interval, Refused, spend

SERIES = ("sin", "cos", "exp")
PARTIAL = ("log", "sqrt", "inv")  # where the argument is not above 0 (inv: is 0) nothing is known of them
TERMS = 12
_GRID = 1 << 64
_OF_NUMBER = re.compile(r"(sin|cos|exp)\(([1-9][0-9]{0,40}(?:/[1-9][0-9]{0,40})?)\)")


class Functions:
    """The functions met so far: a name such as `cos(1/5+1/5*x)` for the function and its argument."""

    def __init__(self) -> None:
        self.known: dict[str, tuple[str, Poly]] = {}

    def apply(self, op: str, a: Poly) -> Poly:
        """`op(a)` as a polynomial in names; odd and even functions of `-a` are those of `a`."""
        if not a.terms and op not in ("log", "inv"):
            return ZERO if op in ("sin", "sqrt") else ONE
        exact = _exactly(op, constant(a))
        if exact is not None:
            return const(exact)
        sign = -1 if op in ("sin", "cos") and a.terms[min(a.terms)] < 0 else 1
        b = scale(a, sign)
        text = "+".join("*".join([str(Fraction(b.terms[m], b.unit)), *m]) for m in sorted(b.terms))
        spend(len(text))
        for each in ("sin", "cos") if op in ("sin", "cos") else (op,):
            self.known[f"{each}({text})"] = (each, b)
        return scale(var(f"{op}({text})"), sign if op == "sin" else 1)

    def of_numbers(self, found: Iterable[str]) -> None:
        """Meets the functions of rationals among names, such as `cos(1/5)`, which are numbers."""
        for told in filter(None, map(_OF_NUMBER.fullmatch, found)):
            self.apply(told[1], const(Fraction(told[2])))

    def support(self, found: Iterable[str]) -> Iterator[str]:
        """The names that names stand for: themselves, or what the argument of a function is made of."""
        for n in found:
            if n in self.known:
                yield from self.support(names(self.known[n][1]))
            else:
                yield n

    def substitute(self, p: Poly, env: Env) -> Poly:
        """`p` with names replaced at once, also inside of functions."""
        inner = {n: self.known[n] for n in names(p) if n in self.known and not env.keys().isdisjoint(self.support([n]))}
        images = {n: self.apply(op, self.substitute(a, env)) for n, (op, a) in inner.items()}
        return substitute(p, Env({**env, **images}) if images else env)

    def derivative(self, p: Poly, rates: dict[str, Poly]) -> Poly:
        """The derivative of `p` along a flow; names without a rate are constant."""
        return total((1, mul(partial(p, n), self._rate(n, rates))) for n in sorted(names(p)))

    def _rate(self, name: str, rates: dict[str, Poly]) -> Poly:
        if name not in self.known:
            return rates.get(name, ZERO)
        op, a = self.known[name]
        inner = self.derivative(a, rates)
        if op == "sqrt":
            return mul(scale(self.apply("inv", var(name)), Fraction(1, 2)), inner)
        if op in ("log", "inv"):
            inverse = self.apply("inv", a)
            return mul(inverse if op == "log" else scale(power(inverse, 2), -1), inner)
        outer = {"sin": ("cos", 1), "cos": ("sin", -1), "exp": ("exp", 1)}[op]
        return mul(scale(self.apply(outer[0], a), outer[1]), inner)

    def partial(self, p: Poly) -> Iterator[tuple[str, Poly]]:
        """Functions in a polynomial that are not defined everywhere, with their arguments; also inside of others."""
        for op, a in (self.known[n] for n in sorted(names(p)) if n in self.known):
            yield from self.partial(a)
            if op in PARTIAL:
                yield op, a

    def meaning(self, name: str) -> tuple[tuple[str, Poly], list[tuple[str, Poly]]]:
        """Where a root, a logarithm or an inverse is not defined, and literals that hold where it is."""
        op, a = self._of(name, PARTIAL)
        value = var(name)
        if op == "inv":
            return ("==", a), [("==", add(mul(value, a), ONE, -1))]
        if op == "log":
            return ("<=", a), [("<=", total(((1, value), (-1, a), (1, ONE))))]
        return ("<", a), [("==", add(power(value, 2), a, -1)), (">=", value)]

    def circle(self, name: str) -> Poly:
        """`sin^2 + cos^2 - 1` of the argument of a `sin` or `cos`."""
        _, a = self._of(name, ("sin", "cos"))
        return total(((1, power(self.apply("sin", a), 2)), (1, power(self.apply("cos", a), 2)), (-1, ONE)))

    def positive(self, name: str) -> Poly:
        """An exponential, which is above 0."""
        self._of(name, ("exp",))
        return var(name)

    def series(self, name: str, n: int) -> tuple[str, Poly]:
        """What `n` terms of the series bound: `p op 0` for all real arguments.

        `cos a <= 1`, integrated twice and again, bounds `cos a` by `S_n` from above and below in turn, and likewise
        `a sin a` by `a S_n`; with an even number of terms `exp a - S_n` is `exp(t) a^n / n!` for some t.
        """
        op, a = self._of(name, SERIES)
        if type(n) is not int or not 1 <= n <= TERMS or (op == "exp" and n % 2):
            raise Refused("a series has a number of terms that bounds nothing")
        if op == "exp":
            terms = (scale(power(a, k), Fraction(1, factorial(k))) for k in range(n))
            return ">=", total([(1, var(name)), *((-1, t) for t in terms)])
        odd = op == "sin"
        terms = (scale(power(a, 2 * (k + odd)), Fraction((-1) ** k, factorial(2 * k + odd))) for k in range(n))
        whole = mul(var(name), a) if odd else var(name)
        return "<=" if n % 2 else ">=", total([(1, whole), *((-1, t) for t in terms)])

    def _of(self, name: object, ops: tuple[str, ...]) -> tuple[str, Poly]:
        found = self.known.get(name) if isinstance(name, str) else None
        if found is None or found[0] not in ops:
            raise Refused("a fact about a function that is not there")
        return found

    def enclosed(self, box: Box, found: Iterable[str]) -> Box | None:
        """The box with functions bounded by what they are on it; None where it is empty."""
        out = dict(box)
        for n in sorted(found, key=len):  # an argument has a shorter name
            if n in self.known:
                op, a = self.known[n]
                inner = self.enclosed(out, names(a) - out.keys())
                low, high = out[n] = meet(out.get(n, FREE), image(op, bounds(a, inner if inner is not None else out)))
                if low is not None and high is not None and low > high:
                    return None
        return out


def _exactly(op: str, q: Fraction | None) -> Fraction | None:
    """A root, a logarithm or an inverse of a number, where that is a rational seen at once."""
    if q is None or q <= 0:
        return None
    if op == "sqrt":
        root = Fraction(isqrt(q.numerator), isqrt(q.denominator))
        return root if root * root == q else None
    return 1 / q if op == "inv" else Fraction(0) if op == "log" and q == 1 else None


def image(op: str, i: Interval) -> Interval:
    """An enclosure of a function on an interval."""
    spend(2000)
    low, high = i
    if op in PARTIAL:
        return _partial(op, low, high)
    if op == "exp":
        return exponential(low)[0] if low is not None else Fraction(0), None if high is None else exponential(high)[1]
    if low is None or high is None or max(-low, high) > 16:
        return Fraction(-1), Fraction(1)
    ends = [cosine(x, op == "sin") for x in (low, high)]
    least, most = min(e[0] for e in ends), max(e[1] for e in ends)
    for k in range(-6, 7):  # extrema of cos are at k pi, those of sin at (k + 1/2) pi
        place = Fraction(2 * k + (op == "sin"), 2)
        around = sorted((place * PI[0], place * PI[1]))
        if around[0] <= high and around[1] >= low:
            least, most = (least, Fraction(1)) if k % 2 == 0 else (Fraction(-1), most)
    return max(least, Fraction(-1)), min(most, Fraction(1))


def _partial(op: str, low: Fraction | None, high: Fraction | None) -> Interval:
    """The same for roots, logarithms and inverses, which may be anything where they are not defined."""
    if op == "inv" and high is not None and high < 0:
        least, most = _partial(op, -high, None if low is None else -low)
        return None if most is None else -most, None if least is None else -least
    if low is None or low < 0 or (low == 0 and op != "sqrt"):
        return FREE
    if op == "inv":
        return Fraction(0) if high is None else 1 / high, 1 / low
    if op == "sqrt":
        most = None if high is None else Fraction(isqrt(ceil(high * _GRID**2)) + 1, _GRID)
        return Fraction(isqrt(floor(low * _GRID**2)), _GRID), most
    return _logarithm(floor(low * _GRID))[0], None if high is None else _logarithm(ceil(high * _GRID))[1]


def _logarithm(x: int) -> Interval:
    """Bounds of `log(x / GRID)`."""
    if not 0 < x < _GRID**2:
        return FREE
    y, error = logarithm(x, 64)
    return Fraction(y - error, _GRID), Fraction(y + error, _GRID)


def cosine(x: Fraction, is_sine: bool) -> tuple[Fraction, Fraction]:
    """Bounds of `cos x` or `sin x` for |x| <= 16: a partial sum at a near point, Lagrange's rest and the distance."""
    near = Fraction(floor(x * _GRID), _GRID)
    term, k, whole = (near, 1, near) if is_sine else (Fraction(1), 0, Fraction(1))
    while k < 20 or abs(term) > Fraction(1, _GRID):
        term = -term * near * near / ((k + 1) * (k + 2))
        term = Fraction(round(term * _GRID**2), _GRID**2)
        whole, k = whole + term, k + 2
    error = Fraction(2, _GRID)  # the rest is below the last term; 60 roundings and the distance are far below that
    return whole - error - abs(term), whole + error + abs(term)


def exponential(x: Fraction) -> tuple[Fraction, Fraction | None]:
    """Bounds of `exp x`; none above where x is large."""
    if x > 64:
        return Fraction(2**64), None
    if x < -64:
        return Fraction(0), Fraction(1, 2**64)
    near = Fraction(floor(x * _GRID), _GRID)
    y, term, whole = near / 64, Fraction(1), Fraction(1)  # |y| <= 1 + a grid step
    for k in range(1, 31):
        term = Fraction(round(term * y / k * _GRID**2), _GRID**2)
        whole += term
    low, high = whole - Fraction(1, _GRID), whole + Fraction(1, _GRID)  # the rest and the roundings are far below
    for _ in range(6):
        low, high = Fraction(floor(low * low * _GRID**3), _GRID**3), Fraction(ceil(high * high * _GRID**3), _GRID**3)
    return low, high * (1 + Fraction(2, _GRID))  # and `x - near` is below a grid step
