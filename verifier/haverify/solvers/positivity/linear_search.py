"""Solve an ansatz with squares of single polynomials as generators: a linear program, its vertex made exact."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from haverify.maths.elimination import echelon
from haverify.maths.polynomial import Monomial, Polynomial
from haverify.solvers.positivity.ansatz import Ansatz, Found, Key
from haverify.text.record import record

MAX_COLUMNS = 6000
ACTIVE = 1e-9


@record
class Column:
    """A polynomial times a number that is to be found: any, or at least 0."""

    kind: str  # free, strict, cone
    key: Key
    root: Polynomial | None
    poly: Polynomial


def columns(ansatz: Ansatz, with_pairs: bool) -> list[Column]:
    """The generators: the squares of each basis; `with_pairs` those of sums and differences of two members as well."""
    found = [Column("free", f.key, None, f.poly) for f in ansatz.free]
    found += [Column("strict", f.key, None, f.poly) for f in ansatz.strict]
    for cone in ansatz.cones:
        roots = list(cone.basis)
        if with_pairs:
            roots += [a + b for i, a in enumerate(cone.basis) for b in cone.basis[:i]]
            roots += [a - b for i, a in enumerate(cone.basis) for b in cone.basis[:i]]
        if len(found) + len(roots) > MAX_COLUMNS:
            break
        found += [Column("cone", cone.key, q, q * q * cone.factor) for q in roots]
    return found


def solve(ansatz: Ansatz, with_pairs: bool) -> Found | None:
    """A solution of the ansatz by a vertex of the linear program, or None."""
    generators = columns(ansatz, with_pairs)
    rows, right = _rows(ansatz, generators)
    values = _vertex(generators, rows, right)
    if values is None:
        return None
    active = {k for k, v in enumerate(values) if abs(v) > ACTIVE}
    for keep in (active, {k for k, v in enumerate(values) if abs(v) > 1e-6}):
        exact = _exact(rows, right, keep)
        if exact is not None and all(generators[k].kind == "free" or v >= 0 for k, v in exact.items()):
            return _found(generators, exact)
    return None


def _rows(ansatz: Ansatz, generators: Sequence[Column]) -> tuple[list[dict[int, Fraction]], list[Fraction]]:
    """An equation for each monomial, and one that normalises the strict part."""
    by_monomial: dict[Monomial, dict[int, Fraction]] = {m: {} for m in ansatz.target.whole}
    for k, g in enumerate(generators):
        for m, c in g.poly.terms.items():
            by_monomial.setdefault(m, {})[k] = c
    rows = list(by_monomial.values())
    right = [-ansatz.target.terms.get(m, Fraction(0)) for m in by_monomial]
    if ansatz.strict:
        rows.append({k: Fraction(1) for k, g in enumerate(generators) if g.kind == "strict"})
        right.append(Fraction(1))
    return rows, right


def _vertex(generators: Sequence[Column], rows: list[dict[int, Fraction]], right: list[Fraction]) -> Any:
    from scipy.optimize import linprog
    from scipy.sparse import csr_matrix

    if any(not row and r for row, r in zip(rows, right, strict=True)) or not generators:
        return None
    scales = [1 / max(1e-12, max((abs(float(c)) for c in g.poly.terms.values()), default=1.0)) for g in generators]
    data, indices, ends = [], [], [0]
    for row in rows:
        size = max((abs(float(c)) * scales[k] for k, c in row.items()), default=1.0)
        data += [float(c) * scales[k] / size for k, c in row.items()]
        indices += list(row)
        ends.append(len(indices))
    b = [
        float(r) / max((abs(float(c)) * scales[k] for k, c in row.items()), default=1.0)
        for row, r in zip(rows, right, strict=True)
    ]
    cost = [0.01 if g.kind == "free" else 1.0 + 0.1 * g.poly.total_degree() for g in generators]
    matrix = csr_matrix((data, indices, ends), shape=(len(rows), len(generators)))
    cost = [0.0 if g.kind == "free" else c for g, c in zip(generators, cost, strict=True)]
    bounds = [(None, None) if g.kind == "free" else (0, None) for g in generators]
    answer = linprog(cost, A_eq=matrix, b_eq=b, bounds=bounds, method="highs-ds", options={"time_limit": 10.0})
    if answer.status != 0:
        return None
    return list(answer.x)


def _exact(rows: list[dict[int, Fraction]], right: list[Fraction], active: set[int]) -> dict[int, Fraction] | None:
    """The solution with unknowns outside `active` 0, if there is one."""
    kept = [({k: c for k, c in row.items() if k in active}, r) for row, r in zip(rows, right, strict=True)]
    solved = echelon(kept)
    return None if solved is None else solved.solution({})


def _found(generators: Sequence[Column], values: dict[int, Fraction]) -> Found:
    found = Found({}, {}, {})
    for k, v in values.items():
        g = generators[k]
        if g.kind == "free":
            found.free[g.key] = v
        elif g.kind == "strict":
            found.strict[g.key] = v
        elif v:
            assert g.root is not None
            found.cones.setdefault(g.key, []).append((v, g.root))
    return found
