"""Three-valued signals: what is said of uncertain dwells is true of every choice of their lengths, and both programs
say the same."""

from fractions import Fraction as Q

from hypothesis import given, settings
from hypothesis import strategies as st

from hacheck import timeline as second
from haverify.analyses.signals_value import (
    ZERO,
    Dwell,
    Signal,
    Timeline,
    Window,
    at_start,
    both,
    common,
    denied,
    either,
    eventually,
    globally,
    joined,
    until,
)

LAWS = settings(max_examples=80, deadline=None, derandomize=True)
halves = st.integers(0, 6).map(lambda n: Q(n, 2))


@st.composite
def dwells(draw):
    """Lengths between two bounds, and a choice of each."""
    found = []
    for _ in range(draw(st.integers(1, 4))):
        low, more = draw(st.integers(0, 4)), draw(st.sampled_from([0, 0, 1, 2]))
        found.append((Q(low, 2), Q(low + more, 2), Q(low + draw(st.integers(0, more)), 2)))
    return found


def cuts(low, high):
    return st.tuples(st.integers(int(low * 2), int(high * 2)).map(lambda n: Q(n, 2)), st.integers(0, 1))


@st.composite
def sets(draw, lengths):
    """Some instants of each dwell."""
    found = []
    for high in lengths:
        ends = sorted(draw(st.lists(cuts(Q(0), high), min_size=0, max_size=4)))
        spans = joined([(a, b) for a, b in zip(ends[::2], ends[1::2], strict=False)])
        found.append(common(spans, ((ZERO, (high, 1)),)))
    return tuple(found)


windows = st.tuples(halves, halves).map(lambda w: (min(w), max(w)))


@st.composite
def formulas(draw, depth=3):
    if depth == 0 or draw(st.integers(0, 4)) == 0:
        return ["var", draw(st.sampled_from(["p", "q"]))]
    op = draw(st.sampled_from(["not", "and", "or", "implies", "globally", "eventually", "until", "until"]))
    inner = [draw(formulas(depth - 1)) for _ in range(1 if op in ("not", "globally", "eventually") else 2)]
    ends = [str(x) for x in draw(windows)] if op in second.TEMPORAL else []
    return [op, *ends, *inner]


def value(t, e, atoms, rate=(Q(1), Q(1))):
    """The formula's signal, by the analyses."""
    need = len(t.dwells) - 1
    if e[0] == "var":
        return atoms[e[1]]
    inner = [value(t, x, atoms, rate) for x in e[1 if e[0] not in second.TEMPORAL else 3 :]]
    if e[0] in second.TEMPORAL:
        a, b = Q(e[1]), Q(e[2])
        w = Window((a * rate[0], a * rate[1]), (b * rate[0], b * rate[1]))
        return {"globally": globally, "eventually": eventually, "until": until}[e[0]](t, *inner, w, need)
    if e[0] == "not":
        return denied(t, inner[0])
    first = denied(t, inner[0]) if e[0] == "implies" else inner[0]
    return (both if e[0] == "and" else either)(first, inner[1])


def exact(lengths, begin=Q(0)):
    """The timeline of dwells whose lengths are known."""
    found = []
    for d in lengths:
        found.append(Dwell(d, d, (begin, begin)))
        begin += d
    return Timeline(tuple(found))


def loose(lengths):
    """The timeline of dwells of which bounds are known."""
    first = last = Q(0)
    found = []
    for low, high, _ in lengths:
        found.append(Dwell(low, high, (first, last)))
        first, last = first + low, last + high
    return Timeline(tuple(found))


@st.composite
def cases(draw):
    lengths = draw(dwells())
    atoms = {n: draw(sets([h for _, h, _ in lengths])) for n in ("p", "q")}
    return lengths, atoms, draw(formulas())


@LAWS
@given(cases())
def test_bounds_on_dwells_hold_for_every_choice_of_their_lengths(case):
    lengths, atoms, formula = case
    t = loose(lengths)
    said = at_start(value(t, formula, {n: Signal(s, s) for n, s in atoms.items()}))
    chosen = exact([c for _, _, c in lengths])
    there = {
        n: tuple(common(s, ((ZERO, d.end),)) for s, d in zip(x, chosen.dwells, strict=True)) for n, x in atoms.items()
    }
    true = at_start(value(chosen, formula, {n: Signal(s, s) for n, s in there.items()}))
    assert true is not None
    assert said is None or said is true


@LAWS
@given(cases(), st.sampled_from([(Q(1), Q(1)), (Q(9, 10), Q(11, 10))]))
def test_the_checker_says_the_same(case, rate):
    lengths, atoms, formula = case
    t = loose(lengths)
    mine = at_start(value(t, formula, {n: Signal(s, s) for n, s in atoms.items()}, rate))
    other = second.Timeline([second.Dwell(d.low, d.high, *d.clock) for d in t.dwells], rate)

    def read(e):
        found = value(t, e, {n: Signal(s, s) for n, s in atoms.items()})
        return tuple(
            other.union([(other.place(i, *a), other.place(i, *b)) for i, s in enumerate(x) for a, b in s])
            for x in (found.must, found.may)
        )

    must, may = other.value(formula, read, Q)
    start = (0, Q(0), 0)
    theirs = True if must and must[0][0] == start else None if may and may[0][0] == start else False
    assert mine is theirs


@LAWS
@given(cases(), halves, halves, halves)
def test_delays_add_up_and_wider_windows_hold_no_less(case, first, more, wider):
    lengths, atoms, _ = case
    t = exact([c for _, _, c in lengths])
    p = tuple(common(s, ((ZERO, d.end),)) for s, d in zip(atoms["p"], t.dwells, strict=True))
    x, need = Signal(p, p), len(t.dwells) - 1

    def seen(of, a, b, op=eventually):
        return op(t, of, Window((a, a), (b, b)), need)

    if first + more <= sum(d.low for d in t.dwells):
        delayed = seen(seen(x, more, more), first, first)
        assert at_start(delayed) is at_start(seen(x, first + more, first + more))
    narrow, wide = (first, first + more), (max(first - wider, Q(0)), first + more + wider)
    assert at_start(seen(x, *wide)) or not at_start(seen(x, *narrow))
    assert at_start(seen(x, *narrow, globally)) or not at_start(seen(x, *wide, globally))
    reached = until(t, x, x, Window((first, first), (first + more, first + more)), need)
    assert at_start(seen(x, *narrow)) or not at_start(reached)
