"""Solve an ansatz by semidefinite programming, then make the solution exact.

Clarabel gives numbers near a solution in the interior of the cone. They are rounded to rationals, the error of the
identity is moved into the unknowns by exact linear algebra, and what stays positive semidefinite (by exact LDL^T) is a
solution. Nothing numerical survives.

Source              H. Peyrl, P. Parrilo, "Computing sum of squares decompositions with rational coefficients", 2008
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from math import sqrt
from typing import Any, TypeVar

from haverify.maths.definite import squares
from haverify.maths.elimination import echelon
from haverify.maths.polynomial import Monomial, Polynomial, total
from haverify.solvers.positivity.ansatz import Ansatz, Cone, Found, Key
from haverify.text.record import holder, record

MAX_UNKNOWNS = 4000
ROOT2 = sqrt(2.0)
MARGIN = 1e-6
FACES = 4
T = TypeVar("T")
Rows = list[dict[int, Fraction]]


@record
class Sparse:
    """A matrix by compressed columns, as Clarabel reads one."""

    shape: tuple[int, int]
    indptr: list[int]
    indices: list[int]
    data: list[float]
    has_canonical_format: bool = True

    @property
    def nnz(self) -> int:
        """The number of entries."""
        return len(self.data)


@holder
class Layout:
    """Where the unknowns of an ansatz are: numbers, then the upper triangle of each Gram matrix, column by column."""

    ansatz: Ansatz
    start: list[int]
    size: int

    def entry(self, block: int, i: int, j: int) -> int:
        """The place of an entry of a Gram matrix, i <= j."""
        return self.start[block] + j * (j + 1) // 2 + i


def layout(ansatz: Ansatz) -> Layout:
    """The places of the unknowns."""
    place = len(ansatz.free) + len(ansatz.strict)
    start = []
    for cone in ansatz.cones:
        start.append(place)
        place += len(cone.basis) * (len(cone.basis) + 1) // 2
    return Layout(ansatz, start, place)


def equations(of: Layout) -> tuple[list[dict[int, Fraction]], list[Fraction]]:
    """One for each monomial of the identity, and the normalisation of the strict part."""
    rows: dict[Monomial, dict[int, Fraction]] = {m: {} for m in of.ansatz.target.whole}
    for k, f in enumerate((*of.ansatz.free, *of.ansatz.strict)):
        for m, c in f.poly.terms.items():
            rows.setdefault(m, {})[k] = c
    for b, cone in enumerate(of.ansatz.cones):
        _gram_terms(of, b, cone, rows)
    found = list(rows.values())
    right = [-of.ansatz.target.terms.get(m, Fraction(0)) for m in rows]
    if of.ansatz.strict:
        first = len(of.ansatz.free)
        found.append({first + k: Fraction(1) for k in range(len(of.ansatz.strict))})
        right.append(Fraction(1))
    return found, right


def _gram_terms(of: Layout, b: int, cone: Cone, rows: dict[Monomial, dict[int, Fraction]]) -> None:
    for j, right in enumerate(cone.basis):
        scaled = right * cone.factor
        for i in range(j + 1):
            place = of.entry(b, i, j)
            for m, c in (cone.basis[i] * scaled).terms.items():
                rows.setdefault(m, {})[place] = c if i == j else 2 * c


def solve(ansatz: Ansatz, seconds: float) -> Found | None:
    """A solution of the ansatz, or None where none with room around it was found."""
    return _on_faces(ansatz, seconds, _exact)


def approximate(ansatz: Ansatz, seconds: float) -> dict[Key, float] | None:
    """The numbers of the free unknowns near a solution, nothing exact; None where there seems to be none."""

    def read(of: Layout, _rows: Rows, _right: list[Fraction], numbers: list[float]) -> dict[Key, float] | None:
        return {f.key: numbers[k] for k, f in enumerate(of.ansatz.free)} if numbers[-1] > MARGIN else None

    return _on_faces(ansatz, seconds, read)


def _on_faces(
    ansatz: Ansatz, seconds: float, read: Callable[[Layout, Rows, list[Fraction], list[float]], T | None]
) -> T | None:
    """What is read from numbers in the interior; where that is nothing, on smaller and smaller faces of the cone."""
    for _ in range(FACES):
        of = layout(ansatz)
        if of.size > MAX_UNKNOWNS or not of.size:
            return None
        rows, right = equations(of)
        if any(not row and r for row, r in zip(rows, right, strict=True)):
            return None
        numbers = _interior(of, rows, right, seconds)
        if numbers is None:
            return None
        found = read(of, rows, right, numbers)
        smaller = None if found is not None else _face(of, numbers)
        if smaller is None:
            return found
        ansatz = smaller
    return None


def _interior(of: Layout, rows: list[dict[int, Fraction]], right: list[Fraction], seconds: float) -> list[float] | None:
    """Numbers near a solution whose Gram matrices have eigenvalues as far above 0 as possible, up to 1."""
    import clarabel

    columns: list[dict[int, float]] = [{} for _ in range(of.size + 1)]
    b: list[float] = []
    for row, r in zip(rows, right, strict=True):
        size = max((abs(float(c)) for c in row.values()), default=1.0)
        for k, c in row.items():
            columns[k][len(b)] = float(c) / size
        b.append(float(r) / size)
    cones: list[Any] = [clarabel.ZeroConeT(len(b))]
    margin = of.size
    first = len(of.ansatz.free)
    signed = list(range(first, first + len(of.ansatz.strict)))
    signed += [s for s, c in zip(of.start, of.ansatz.cones, strict=True) if len(c.basis) == 1]
    for k in signed:
        columns[k][len(b)] = -1.0
        if k >= first + len(of.ansatz.strict):
            columns[margin][len(b)] = 1.0
        b.append(0.0)
    columns[margin][len(b)] = 1.0
    b.append(1.0)
    cones.append(clarabel.NonnegativeConeT(len(signed) + 1))
    for s, cone in zip(of.start, of.ansatz.cones, strict=True):
        n = len(cone.basis)
        if n > 1:
            _definite(columns, b, s, n, margin)
            cones.append(clarabel.PSDTriangleConeT(n))
    cost = [0.0] * of.size + [-1.0]
    for block, cone in enumerate(of.ansatz.cones):
        for i in range(len(cone.basis)):
            cost[of.entry(block, i, i)] = 1e-8
    return _solved(columns, b, cones, cost, seconds)


def _definite(columns: list[dict[int, float]], b: list[float], start: int, n: int, margin: int) -> None:
    place = start
    for j in range(n):
        for i in range(j + 1):
            columns[place][len(b)] = -1.0 if i == j else -ROOT2
            if i == j:
                columns[margin][len(b)] = 1.0
            b.append(0.0)
            place += 1


def _solved(
    columns: list[dict[int, float]], b: list[float], cones: list[Any], cost: list[float], seconds: float
) -> list[float] | None:
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.time_limit = seconds
    settings.max_iter = 100
    n = len(columns)
    ends, indices, data = [0], [], []
    for column in columns:
        for k in sorted(column):
            indices.append(k)
            data.append(column[k])
        ends.append(len(indices))
    quadratic = Sparse((n, n), [0] * (n + 1), [], [])
    matrix = Sparse((len(b), n), ends, indices, data)
    answer = clarabel.DefaultSolver(quadratic, cost, matrix, b, cones, settings).solve()
    if str(answer.status) not in ("Solved", "AlmostSolved", "InsufficientProgress", "MaxIterations"):
        return None
    numbers = list(answer.x)
    return numbers if numbers[-1] > -1e-4 else None


def _exact(of: Layout, rows: list[dict[int, Fraction]], right: list[Fraction], numbers: list[float]) -> Found | None:
    """The numbers rounded, and moved onto the equations."""
    for digits in (6, 20, 34):
        rounded = {k: Fraction(round(v * 2**digits), 2**digits) for k, v in enumerate(numbers[: of.size])}
        repaired = _spread(of, rows, right, rounded)
        found = None if repaired is None else _found(of, repaired)
        if found is not None:
            return found
    solved = echelon(zip(rows, right, strict=True), last=range(len(of.ansatz.free), of.size))
    if solved is None:
        return None
    rounded = {k: Fraction(round(v * 2**34), 2**34) for k, v in enumerate(numbers[: of.size])}
    return _found(of, solved.solution(rounded))


def _spread(
    of: Layout, rows: list[dict[int, Fraction]], right: list[Fraction], values: dict[int, Fraction]
) -> dict[int, Fraction] | None:
    """The values with each equation's error shared out among unknowns that are in no other equation."""
    counts: dict[int, int] = {}
    for row in rows:
        for k in row:
            counts[k] = counts.get(k, 0) + 1
    fixed = dict(values)
    for row, r in zip(rows, right, strict=True):
        off = r - sum((c * values[k] for k, c in row.items()), Fraction(0))
        if off:
            own = [k for k in row if counts[k] == 1 and k >= len(of.ansatz.free)]
            if not own:
                return None
            weight = sum((row[k] ** 2 for k in own), Fraction(0))
            for k in own:
                fixed[k] += off * row[k] / weight
    return fixed


def _found(of: Layout, values: dict[int, Fraction]) -> Found | None:
    """The solution the values give, if they are signed as they have to be."""
    free = len(of.ansatz.free)
    found = Found({f.key: values.get(k, Fraction(0)) for k, f in enumerate(of.ansatz.free)}, {}, {})
    for k, f in enumerate(of.ansatz.strict):
        found.strict[f.key] = values.get(free + k, Fraction(0))
        if found.strict[f.key] < 0:
            return None
    for b, cone in enumerate(of.ansatz.cones):
        sums = _squares(of, b, cone, values)
        if sums is None:
            return None
        found.cones[cone.key] = sums
    return found


def _squares(of: Layout, b: int, cone: Cone, values: dict[int, Fraction]) -> list[tuple[Fraction, Polynomial]] | None:
    n = len(cone.basis)
    gram = [[values.get(of.entry(b, min(i, j), max(i, j)), Fraction(0)) for j in range(n)] for i in range(n)]
    parts = squares(gram)
    if parts is None:
        return None
    return [(q, total(z.scaled(c) for z, c in zip(cone.basis, v, strict=True) if c)) for q, v in parts]


def _face(of: Layout, numbers: list[float]) -> Ansatz | None:
    """The ansatz on the face of the cone that the numbers lie on: without the kernels of the matrices."""
    import numpy

    cones = []
    smaller = False
    for b, cone in enumerate(of.ansatz.cones):
        n = len(cone.basis)
        gram = numpy.array([[numbers[of.entry(b, min(i, j), max(i, j))] for j in range(n)] for i in range(n)])
        size = max(1.0, float(abs(gram).max()))
        values, vectors = numpy.linalg.eigh(gram)
        small = [k for k in range(n) if values[k] < 1e-5 * size]
        if small and len(small) < n:
            basis = _complement(cone.basis, vectors[:, small])
            smaller = smaller or len(basis) < n
            cones.append(Cone(cone.key, cone.factor, basis))
        elif len(small) == n:
            smaller = True
        else:
            cones.append(cone)
    return Ansatz(of.ansatz.target, of.ansatz.free, tuple(cones), of.ansatz.strict) if smaller else None


def _complement(basis: tuple[Polynomial, ...], kernel: Any) -> tuple[Polynomial, ...]:
    """A basis of what is orthogonal to rational vectors near the kernel; the basis itself where there are none."""
    import numpy

    n = len(basis)
    vectors = numpy.array(kernel.T, dtype=float)
    pivots: list[int] = []
    for r in range(len(vectors)):
        rest = abs(vectors[r]).copy()
        rest[pivots] = 0
        p = int(rest.argmax())
        vectors[r] /= vectors[r][p]
        for other in range(len(vectors)):
            if other != r:
                vectors[other] -= vectors[other][p] * vectors[r]
        pivots.append(p)
    rational = [[Fraction(float(x)).limit_denominator(64) for x in row] for row in vectors]
    close = [
        (p, row)
        for p, row, v in zip(pivots, rational, vectors, strict=True)
        if max(abs(float(a) - x) for a, x in zip(row, v, strict=True)) < 2e-3
    ]
    gone = dict(close)
    kept = [k for k in range(n) if k not in gone]
    found = []
    for k in kept:
        found.append(total([basis[k], *(basis[p].scaled(-row[k]) for p, row in gone.items() if row[k])]))
    return tuple(found)
