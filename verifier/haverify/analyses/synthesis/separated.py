"""Cuts that are barriers between starts and unsafe states, from semidefinite programs."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from time import process_time

from haverify.analyses.synthesis.barriers import Shape, barrier
from haverify.analyses.synthesis.candidates import below
from haverify.analyses.synthesis.samples import branches
from haverify.analyses.synthesis.search import Search
from haverify.obligations.formula import Literal
from haverify.solvers.positivity.levels import AFFINE, HIGHER, SQUARES

RATES = (Fraction(0), Fraction(-1), Fraction(1), Fraction(-1, 4), Fraction(-5), Fraction(-1, 10))
FIRST = tuple(Shape(d, d + more, r) for d, more in ((2, 0), (2, 2), (4, 2)) for r in RATES)
LATER = tuple(Shape(d, d + 4, r) for d in (2, 4, 6) for r in RATES)


def barriers(search: Search, shapes: Sequence[Shape]) -> None:
    """A barrier between the starts and each kind of unsafe states."""
    domain = [e for e in search.premises().entries if isinstance(e, Literal)]
    starts = [b for s in search.system.starts for b in branches(s.entries)]
    for part in list(search.open):
        linked = search.linked([part])
        names = tuple(v for v in search.samples.names if v in linked)
        for unsafe in branches([part]):
            for shape in shapes:
                if search.is_over() or (
                    len(starts) == 1 and _is_separated(search, domain, starts[0], unsafe, names, shape)
                ):
                    break


def _is_separated(
    search: Search,
    domain: Sequence[Literal],
    start: Sequence[Literal],
    unsafe: Sequence[Literal],
    names: tuple[str, ...],
    shape: Shape,
) -> bool:
    seconds = max(0.5, (search.until - process_time()) / 3)
    about = [[q for q in side if set(q.polynomial.variables) <= set(names)] for side in (domain, start, unsafe)]
    p = barrier(about[0], about[1], [*about[0], *about[2]], search.system.field, names, shape, seconds)
    return p is not None and search.attempt([below(p)], (AFFINE, SQUARES, HIGHER))
