"""The automaton as the kernel takes it: tapes, guards, and what is judged, by mode."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

from haverify.analyses.hybrid.conditions import CLOSED, Atom, Condition, Every, atoms, closed, condition
from haverify.analyses.hybrid.inputs import Chosen, fields
from haverify.analyses.hybrid.model import HybridModel
from haverify.maths.interval import Interval
from haverify.model.expression import Expr, nodes, rebuild
from haverify.model.hybrid import Edge, Range
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import OutsideFragmentError
from haverify.solvers.kernel import INPUT, EdgeListing, Listing, ModeListing, Pair, Tape, Words
from haverify.text.record import field, holder, record

Q = Fraction

ZERO, ONE = Expr("num", (Q(0),)), Expr("num", (Q(1),))
BEFORE = "before the jump: "
CHOICE = "choice: "
MOST_CASES = 16
NOTHING: Chosen = {}


@holder
class Watched:
    """The quantities that one mode watches, each once, and conditions as words on their positions."""

    tape: Tape
    outputs: list[int] = field(default_factory=list)
    positions: dict[int, int] = field(default_factory=dict)

    def position(self, quantity: Expr) -> int:
        """The position of a quantity among the outputs."""
        register = self.tape.add(quantity)
        if register not in self.positions:
            self.positions[register] = len(self.outputs)
            self.outputs.append(register)
        return self.positions[register]

    def words(self, c: Condition) -> Words:
        """A condition as the kernel reads it."""
        if isinstance(c, bool):
            return [("true" if c else "false", 0)]
        if isinstance(c, Atom):
            return [(c.op, self.position(c.quantity))]
        found: Words = [("all" if isinstance(c, Every) else "any", len(c.members))]
        for member in c.members:
            found += self.words(member)
        return found

    def listing(self) -> Listing:
        """The tape of the quantities."""
        return self.tape.listing(self.outputs)


@record
class Judged:
    """What is judged: a condition while dwelling in each mode, and one right after each edge of the automaton."""

    dwelling: tuple[Condition, ...]
    landing: dict[int, Condition]
    window: Condition
    # For each mode, what runs that are judged keep: comparisons read as closed; conditions as they are written.
    facts: tuple[tuple[Atom, ...], ...]
    assumed: tuple[tuple[Condition, ...], ...]


def listings(
    model: HybridModel,
    judged: Judged,
    compared: list[list[tuple[Expr, str, int]]] | None = None,
    chosen: Chosen = NOTHING,
) -> list[ModeListing]:
    """The automaton as the kernel takes it, with what is to be judged.

    `compared` is filled with the comparisons of each mode's claim and the window, and where their quantities are;
    `chosen` has narrower ranges of inputs.

    Raises
    ------
    OutsideFragmentError    naming the construct that is in the way
    """
    model.edges[:] = [[] for _ in model.modes]
    found = [] if compared is None else compared
    return [_mode(model, number, judged, found, chosen) for number in range(len(model.modes))]


def _numbers(names: Sequence[str]) -> dict[str, int]:
    return {n: i for i, n in enumerate(names)}


def _mode(
    model: HybridModel,
    number: int,
    judged: Judged,
    compared: list[list[tuple[Expr, str, int]]],
    chosen: Chosen,
) -> ModeListing:
    mode, known = model.modes[number], model.definitions[number]
    at = Situation(model.places[number].mode)
    variables = _numbers(model.names)
    rates, driven = fields(model, mode)
    # Where a claim has modes of its own, others with the same names may have other fields.
    flows = model.compiled if model.is_plain else {}
    key = model.automaton.name, model.names, mode.name
    if key not in flows:
        flows[key] = _flow(model, number, rates, [d.name for d in driven])
    watched = Watched(Tape(variables, known))
    domain = [*_conjuncts(closed(condition(residual(mode.domain, at), known)))]
    borders = [c for c in domain if isinstance(c, Atom)]
    guard = [(watched.position(a.quantity), a.op) for a in borders]
    # Where the ends of an inclusion are not in order, there is no rate that could be chosen.
    ordered = [Atom(d.order, ">=") for d in driven if d.order is not None and chosen]
    also = (*(c for c in domain if not isinstance(c, Atom)), *judged.assumed[number], *ordered)
    rest = watched.words(Every(also))
    facts = [(watched.position(a.quantity), a.op) for a in judged.facts[number]]
    leaving = [(k, e) for k, e in enumerate(model.automaton.edges) if e.source == mode.name]
    guards = [(k, e, _cases(condition(residual(e.guard, at), known))) for k, e in leaving]
    # What runs depend on is watched first: at the same positions whatever the claim.
    for atom in (a for _, _, cases in guards for case in cases for a in case):
        watched.position(atom.quantity)
    claim, window = watched.words(judged.dwelling[number]), watched.words(judged.window)
    claimed = [*atoms(judged.dwelling[number]), *atoms(judged.window)]
    compared.append([(a.quantity, a.op, watched.position(a.quantity)) for a in claimed])
    edges = []
    for index, edge, cases in guards:
        for case in cases:
            edges.append(_edge(model, number, edge, case, borders, judged.landing[index], watched))
            model.edges[number].append(index)
    ranges = [_ends(chosen.get(d.name, (d.low, d.high))) for d in driven]
    return flows[key], ranges, watched.listing(), guard, facts, rest, claim, window, edges


def _flow(model: HybridModel, number: int, rates: dict[str, Expr], driven: Sequence[str]) -> Listing:
    """The rates of the state as functions of it and of what drives it."""
    flow = Tape(_numbers([*model.names, *(INPUT + n for n in driven)]), model.definitions[number])
    field = [flow.add(rates.get(n, ZERO)) for n in model.names[:-1]]
    return flow.listing([*field, flow.add(ONE)])


def _ends(pair: tuple[Q, Q]) -> Pair:
    x = Interval.between(*pair)
    return x.low, x.high


def _conjuncts(c: Condition) -> Iterator[Condition]:
    """The members of a conjunction that are none themselves."""
    if isinstance(c, Every):
        for member in c.members:
            yield from _conjuncts(member)
    elif c is not True:
        yield c


def _cases(c: Condition) -> list[list[Atom]]:
    """A guard as conjunctions of which one at least holds."""
    if isinstance(c, bool):
        return [[]] if c else []
    if isinstance(c, Atom):
        return [[c]]
    if isinstance(c, Every):
        found: list[list[Atom]] = [[]]
        for member in c.members:
            found = [[*a, *b] for a in found for b in _cases(member)]
    else:
        found = [case for m in c.members for case in _cases(m)]
    if len(found) > MOST_CASES:
        raise OutsideFragmentError("a guard with too many cases")
    return found


def _edge(
    model: HybridModel,
    source: int,
    edge: Edge,
    case: Sequence[Atom],
    domain: Sequence[Atom],
    claim: Condition,
    watched: Watched,
) -> EdgeListing:
    guard = [(watched.position(a.quantity), a.op) for a in case]
    reset, choices = _reset(model, source, edge, _pinned(model, [*case, *domain]))
    target = model.mode(edge.target)
    after = (*model.names, *(BEFORE + n for n in model.names))
    landing = Watched(Tape(_numbers(after), model.definitions[target]))
    words = landing.words(claim)
    return target, edge.urgent, guard, reset, choices, landing.listing(), words


def _pinned(model: HybridModel, atoms: Sequence[Atom]) -> dict[str, Expr]:
    """Variables whose value at a jump is known exactly: the domain and the guard leave one number to them."""
    signs: dict[Expr, set[str]] = {}
    for a in atoms:
        signs.setdefault(a.quantity, set()).add(CLOSED.get(a.op, a.op))
    found = {}
    for quantity, ops in signs.items():
        if "==" in ops or {"<=", ">="} <= ops:
            left, right = quantity.children if quantity.op == "-" and len(quantity.children) == 2 else (quantity, ZERO)
            if left.op == "var" and all(n.op in ("num", "const", "param", "+", "-", "*") for n in nodes(right)):
                found[left.name] = right
    return found


def _reset(model: HybridModel, source: int, edge: Edge, pinned: dict[str, Expr]) -> tuple[Listing, int]:
    """The state after a jump from the state before it and choices, each from -1 to 1."""
    chosen = [a.var for a in edge.resets if isinstance(a.to, Range)]
    names = (*model.names, *(CHOICE + n for n in chosen))
    tape = Tape(_numbers(names), model.definitions[source])
    wanted = {v: Expr("var", (v,)) for v in model.names[:-1]}
    for a in edge.resets:
        wanted[a.var] = _chosen(model, a.var, a.to) if isinstance(a.to, Range) else a.to
    at = Situation(model.places[source].mode)
    outputs = [tape.add(_substituted(residual(wanted[v], at), pinned)) for v in model.names[:-1]]
    outputs.append(tape.add(Expr("time")))
    return tape.listing(outputs), len(chosen)


def _chosen(model: HybridModel, variable: str, to: Range) -> Expr:
    """A value of a range, as an expression of a choice."""
    low, high = model.values.interval(to)
    if low > high:
        raise OutsideFragmentError(f"`{variable}` is set to a value between {low} and {high}, of which there is none")
    half = Expr("num", ((high - low) / 2,))
    return Expr("+", (Expr("num", ((low + high) / 2,)), Expr("*", (half, Expr("var", (CHOICE + variable,))))))


def _substituted(e: Expr, pinned: dict[str, Expr]) -> Expr:
    if e.op == "var" and e.name in pinned:
        return pinned[e.name]
    return rebuild(e, lambda c: _substituted(c, pinned))


def landing_condition(model: HybridModel, number: int, e: Expr, is_denied: bool = False) -> Condition:
    """A condition at the instant after a jump: `pre` reads the state before it."""
    edge = model.automaton.edges[number]
    source, target = model.definitions[model.mode(edge.source)], model.definitions[model.mode(edge.target)]
    return condition(_split(model.landing(e, number), source, is_before=False), target, is_denied)


def _split(e: Expr, source: dict[tuple[str, str], Expr], is_before: bool) -> Expr:
    """`pre(e)` as `e` of variables of their own, lets written out as the source mode defines them."""
    if e.op == "pre":
        return _split(e.children[0], source, is_before=True)
    if is_before and e.op in ("var", "time"):
        return Expr("var", (BEFORE + (e.name if e.op == "var" else "time"),), e.unit, e.span)
    if is_before and e.op == "let":
        return _split(source[e.op, e.name], source, is_before=True)
    return rebuild(e, lambda c: _split(c, source, is_before))
