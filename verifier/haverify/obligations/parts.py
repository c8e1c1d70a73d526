"""The parts of an `always` goal (docs/core.md section 4): which questions a claim comes down to, in their order."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import Edge, HybridAutomaton
from haverify.obligations.residual import Situation, residual
from haverify.text.record import record

NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}
JUMPY = frozenset({"jump", "jumped", "pre"})


@record
class Group:
    """The conjuncts with one output, and the modes where one of them can be anything but true (None: any mode)."""

    output: str
    conjuncts: tuple[Expr, ...]
    modes: frozenset[str] | None
    mentions_jumps: bool


@record
class Part:
    """One question: the residuals of a group in one mode (`dwell`, `stuck`) or at one edge (`jump`, by its index)."""

    kind: str
    where: str
    output: str
    mode: str
    edge: int | None
    residuals: tuple[Expr, ...]


def pushed(e: Expr) -> Expr:
    """`e` with a negation at its top pushed inwards by one level."""
    if e.op != "not":
        return e
    (inner,) = e.children
    if inner.op == "not":
        return inner.children[0]
    if inner.op == "or":
        return Expr("and", tuple(Expr("not", (c,), None, c.span) for c in inner.children), None, e.span)
    if inner.op == "implies":
        premise, conclusion = inner.children
        return Expr("and", (premise, Expr("not", (conclusion,), None, conclusion.span)), None, e.span)
    if inner.op in NEGATED:
        return Expr(NEGATED[inner.op], inner.args, inner.unit, inner.span)
    return e


def conjuncts(e: Expr) -> list[Expr]:
    """The conjunction's members, an implication distributed over those of its conclusion."""
    if e.op == "and":
        return [c for member in e.children for c in conjuncts(member)]
    if e.op == "implies":
        premise, conclusion = e.children
        members = conjuncts(conclusion)
        if len(members) == 1 and members[0] is conclusion:
            return [e]
        return [Expr("implies", (premise, c), e.unit, c.span or e.span) for c in members]
    return [e]


def groups(condition: Expr) -> list[Group]:
    """The conjuncts of a goal's condition by output, in order of first appearance."""
    found: dict[str, list[Expr]] = {}
    for c in conjuncts(pushed(condition)):
        found.setdefault(output_of(c), []).append(c)
    return [_group(output, tuple(members)) for output, members in found.items()]


def _group(output: str, members: tuple[Expr, ...]) -> Group:
    modes = [relevant_modes(c) for c in members]
    known = [m for m in modes if m is not None]
    union = frozenset[str]().union(*known) if len(known) == len(modes) else None
    return Group(output, members, union, any(n.op in JUMPY for c in members for n in nodes(c)))


def output_of(e: Expr) -> str:
    """The names of the lets it mentions, else of the variables, sorted and joined."""
    names: dict[str, set[str]] = {"let": set(), "var": set()}
    for n in nodes(e):
        if n.op in names:
            names[n.op].add(n.name)
    return ",".join(sorted(names["let"] or names["var"]))


def relevant_modes(conjunct: Expr) -> frozenset[str] | None:
    """The modes outside which a dwelling state satisfies the conjunct by its shape alone; None: no such restriction."""
    return _possible(conjunct.children[0]) if conjunct.op in ("implies", "not") else None


def _possible(premise: Expr) -> frozenset[str] | None:
    """The modes in which a dwelling state may satisfy the premise; None: any."""
    if premise.op == "at":
        return frozenset({premise.name})
    if premise.op in ("jumped", "jump"):
        return frozenset()
    if premise.op not in ("and", "or"):
        return None
    members = [_possible(c) for c in premise.children]
    known = [m for m in members if m is not None]
    if premise.op == "or":
        return frozenset[str]().union(*known) if len(known) == len(members) else None
    return frozenset.intersection(*known) if known else None


def parts(condition: Expr, automaton: HybridAutomaton, by_name: dict[str, int]) -> Iterator[Part]:
    """The parts of `always condition`, in order; `by_name` gives each mode its position.

    Modes that no group can concern are skipped without a look, so that a claim about one mode of many is cheap.
    """
    if is_never_stuck(condition):
        for mode in automaton.modes:
            yield Part("stuck", mode.name, "", mode.name, None, ())
        return
    grouped = groups(condition)
    for index in _concerned(grouped, automaton, by_name):
        name = automaton.modes[index].name
        for group in grouped:
            if group.modes is None or name in group.modes:
                yield from _part(group, "dwell", name, None, Situation(name))
    jumpy = [g for g in grouped if g.mentions_jumps]
    if jumpy:
        names = edge_names(automaton.edges)
        for k, edge in enumerate(automaton.edges):
            for group in jumpy:
                yield from _part(group, "jump", names[k], k, Situation(edge.target, edge.source, edge.name))


def is_never_stuck(condition: Expr) -> bool:
    """Whether the goal is `always not stuck`."""
    return condition.op == "not" and condition.children[0].op == "stuck"


def _concerned(grouped: Sequence[Group], automaton: HybridAutomaton, by_name: dict[str, int]) -> Sequence[int]:
    if any(g.modes is None for g in grouped):
        return range(len(automaton.modes))
    return sorted({by_name[m] for g in grouped for m in (g.modes or ()) if m in by_name})


def _part(group: Group, kind: str, where: str, edge: int | None, at: Situation) -> Iterator[Part]:
    residuals = tuple(residual(c, at) for c in group.conjuncts)
    if any(r.op != "true" for r in residuals):
        if kind == "jump":  # what does not speak of jumps is a question of the mode that is entered
            pairs = zip(group.conjuncts, residuals, strict=True)
            residuals = tuple(r for c, r in pairs if any(n.op in JUMPY for n in nodes(c)))
        yield Part(kind, where, group.output, at.mode, edge, residuals)


def edge_names(edges: Sequence[Edge]) -> list[str]:
    """`source -> target` for each edge, with its name where two edges join the same modes."""
    pairs: dict[tuple[str, str], int] = {}
    for e in edges:
        pairs[e.source, e.target] = pairs.get((e.source, e.target), 0) + 1
    return [f"{e.source} -> {e.target}" + (f" ({e.name})" if pairs[e.source, e.target] > 1 else "") for e in edges]
