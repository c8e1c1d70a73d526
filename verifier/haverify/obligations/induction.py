"""An automaton and an `always` goal as the questions an invariant comes down to (docs/core.md section 9)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from fractions import Fraction
from functools import cached_property
from itertools import product
from math import prod

from haverify.maths.bernstein import bounds
from haverify.maths.polynomial import Polynomial, constant, variable
from haverify.model.claim import Claim, Goal
from haverify.model.expression import Expr, nodes
from haverify.model.hybrid import HybridAutomaton, Init, Input, Mode, Range
from haverify.model.spec import Spec
from haverify.obligations.constants import Values, params_of, values_of
from haverify.obligations.formula import Formula, Literal, compare, conjunction, literals
from haverify.obligations.formula import negation as denied
from haverify.obligations.functions import Functions
from haverify.obligations.horizon import implied_end
from haverify.obligations.parts import JUMPY, edge_names
from haverify.obligations.premises import Premises, mapped
from haverify.obligations.reading import Reading
from haverify.obligations.residual import Situation, residual
from haverify.obligations.translate import Case, OutsideFragmentError, Scope
from haverify.text.record import field, holder, record, replace

Q = Fraction
Invariant = Mapping[str, Formula]  # a formula for each mode
TIME, ONE, MANY = "time", constant(1), 5000


@record
class Obligation:
    """One part: what has to have no common point (`flow`: what is known at all times); a formula to be kept there.

    Neither may `undefined` have any: in each list a root or a logarithm is evaluated that has no value (LANGUAGE S1).
    """

    kind: str
    where: str
    mode: str
    premises: Premises
    kept: Formula | None = None
    edge: int | None = None
    undefined: tuple[Premises, ...] = ()


@holder
class Induction:
    """A goal on an automaton; `using` are the conditions of invariants that may be taken for granted.

    Raises
    ------
    OutsideFragmentError    from any method, naming what is in the way
    """

    spec: Spec
    automaton: HybridAutomaton
    claim: Claim
    goal: Goal
    using: tuple[Expr, ...] = ()
    functions: Functions = field(default_factory=Functions)
    _scopes: dict[str, Scope] = field(default_factory=dict)

    def check(self) -> None:
        """Raise OutsideFragmentError where the automaton or the goal is outside of what can be asked."""
        a = self.automaton
        if a.priorities:
            raise OutsideFragmentError("priorities: invariants of this version have none")
        if any(v.type == "bool" for v in a.vars):
            raise OutsideFragmentError("truth variables beside a flow that is not clock-driven")
        asked = (self.goal.condition, *self.spec.assumptions, *self.claim.assume, *self.using)
        if self.goal.kind not in ("always", "can_reach") or any(
            n.op in JUMPY | {"stuck"} for e in asked for n in nodes(e)
        ):
            raise OutsideFragmentError("an invariant shows `always` goals that do not speak of jumps")
        self._check_inputs(asked)
        for m in a.modes:  # the functions that formulas may read are met
            self.field(m.name)
            self.aim(m.name)
            self.common(m.name)
            if m.terminal and TIME in self.functions.support(names_of(self.aim(m.name))):  # S12: it may be frozen there
                raise OutsideFragmentError(f"time in a claim about the terminal mode {m.name}")
        for k in range(len(a.edges)):
            self._check_types(k)

    @property
    def has_inputs(self) -> bool:
        """Whether there are any."""
        return bool(self.inputs)

    @cached_property
    def inputs(self) -> dict[str, Input]:
        """The inputs that the automaton may read."""
        return {i.name: i for i in (*self.spec.inputs, *self.automaton.inputs)}

    def _check_inputs(self, asked: Iterable[Expr]) -> None:
        """Raise OutsideFragmentError for inputs without bounds, and where what is said of states depends on them."""
        a = self.automaton
        if any(i.range is None or i.type != "real" for i in self.inputs.values()):
            raise OutsideFragmentError("an input without two bounds, or that is no number")
        lets = [o.expr for o in (*a.lets, *(o for m in a.modes for o in m.lets))]
        said = [self.condition, *asked, *lets, *(m.domain for m in a.modes), *(i.where for i in a.init)]
        if self.inputs and any(n.op == "input" for e in said for n in nodes(e)):
            raise OutsideFragmentError("an input elsewhere than in flows, guards and resets")

    def _check_types(self, k: int) -> None:
        """Raise OutsideFragmentError where edge k may give a discrete variable a value that its type does not have."""
        edge = self.automaton.edges[k]
        types = {v.name: self._type_range(v.type) for v in self.automaton.vars if v.type != "real"}
        scope, resets = self.scope(edge.source), [a for a in edge.resets if a.var in types]
        guard = self.formula(edge.guard, edge.source, is_closed=edge.urgent, is_told=True)
        taken = conjunction([guard, *self.common(edge.source)]) if resets else False
        for a in resets:
            ends = [scope.polynomial(e) for e in ((a.to.low, a.to.high) if isinstance(a.to, Range) else (a.to,))]
            low, high = types[a.var]
            for values in self._values_of({*names_of(taken), *(v for p in ends for v in p.variables)}):
                found = [self.functions.substitute(p, values).constant for p in ends]
                is_kept = all(q is not None and low <= q <= high for q in found)
                if not is_kept and mapped(taken, values, self.functions) is not False:
                    raise OutsideFragmentError(f"edge {edge.name} may give {a.var} a value that its type does not have")

    def _values_of(self, names: set[str]) -> Iterator[dict[str, Polynomial]]:
        """All values that the discrete ones of some variables have together."""
        ends = {v.name: self._type_range(v.type) for v in self.automaton.vars if v.type != "real" and v.name in names}
        if prod(int(high - low) + 1 for low, high in ends.values()) > MANY:
            raise OutsideFragmentError("the discrete variables have too many values together")
        for point in product(*(range(int(low), int(high) + 1) for low, high in ends.values())):
            yield {v: constant(n) for v, n in zip(ends, point, strict=True)}

    @cached_property
    def values(self) -> Values:
        """What constants are worth."""
        return values_of(self.spec, self.automaton)

    @cached_property
    def named(self) -> Values:
        """What constants are worth that may read params."""
        params = {n: p for n, p in self.names.items() if n in self.params}
        return replace(self.values, known={}, names=params)

    @cached_property
    def params(self) -> dict[str, tuple[Q, Q]]:
        """The ranges of the params."""
        return {p.name: self.values.interval(p.range) for p in params_of(self.spec, self.automaton)}

    @cached_property
    def condition(self) -> Expr:
        """What has to hold always."""
        e = self.goal.condition
        return e if self.goal.kind == "always" else Expr("not", (e,))

    @cached_property
    def limit(self) -> Q | None:
        """The last instant that the goal speaks of."""
        ends = [self.values.number(e) for e in (self.claim.time, self.goal.within) if e is not None]
        ends += [self.values.number(self.goal.window[1])] if self.goal.window is not None else []
        over = implied_end(self.condition, self._number)
        ends += [over] if over is not None else []
        return min(ends) if ends else None

    def _number(self, e: Expr) -> Q | None:
        try:
            return self.values.number(e)
        except OutsideFragmentError:
            return None

    def mode(self, name: str) -> Mode:
        """The mode of a name."""
        return next(m for m in self.automaton.modes if m.name == name)

    @cached_property
    def names(self) -> dict[str, Polynomial]:
        """Variables and params; a param with one value is that number."""
        fixed = {n: constant(low) if low == high else variable(n) for n, (low, high) in self.params.items()}
        return {**fixed, **{n: variable(n) for n in (*self.inputs, *(v.name for v in self.automaton.vars))}}

    def scope(self, mode: str, after: Mapping[str, Polynomial] | None = None) -> Scope:
        """What names mean in a mode, or there after a jump that gives variables these values."""
        if after is None and mode in self._scopes:
            return self._scopes[mode]
        lets = {o.name: (o.type, o.expr) for o in (*self.automaton.lets, *self.mode(mode).lets)}
        found = Scope(
            f"mode {mode}",
            {**self.names, **(after or {})},
            lets,
            self.named.constant,
            self.values.symbol,
            frozenset(),
            {},
            (variable(TIME), ONE),
            {n: r for n, r in self.params.items() if r[0] < r[1]},
            function=self.functions.apply,
        )
        if after is None:
            self._scopes[mode] = found
        return found

    def formula(
        self, e: Expr, mode: str, scope: Scope | None = None, *, is_closed: bool = False, is_told: bool = False
    ) -> Formula:
        """A condition in a mode; `is_closed`: read as a closed set (LANGUAGE S6); `is_told`: a guard or a start's.

        What is told, and domains, hold whatever roots and logarithms are where these are not defined; what is claimed
        or assumed holds only where all that it reads is defined.
        """
        if any(n.op == "der" for n in nodes(e)):
            raise OutsideFragmentError("`der` in a claim about a flow that is not clock-driven")
        known = scope or self.scope(mode)
        return known.formula(Reading(mode, known, is_closed, is_closed or is_told).inward(residual(e, Situation(mode))))

    def aim(self, mode: str, scope: Scope | None = None) -> Formula:
        """What the goal claims in a mode."""
        return self.formula(self.condition, mode, scope)

    def field(self, mode: str) -> dict[str, Polynomial]:
        """The rates in a mode, and of time, all times what is above 0 and makes them polynomials."""
        quotients: dict[str, tuple[Polynomial, Polynomial]] = {}
        for line in self.mode(mode).flow:
            if isinstance(line.rate, Range):
                raise OutsideFragmentError(f"`{line.var}' in [..]` in mode {mode} is an inclusion")
            quotients[line.var] = self._quotient(
                self.scope(mode).cases(line.rate), f"`{line.var}'` in mode {mode}", mode
            )
        divisors = list(dict.fromkeys(d for _, d in quotients.values() if d != ONE))
        clock = prod(divisors, start=ONE)
        rates = {v: n * prod((e for e in divisors if e != d), start=ONE) for v, (n, d) in quotients.items()}
        return rates | {TIME: clock}

    def _quotient(self, cases: list[Case], what: str, mode: str) -> tuple[Polynomial, Polynomial]:
        """The one value of a rate, its divisor above 0."""
        if len(cases) > 1 or cases[0].condition is not True:
            raise OutsideFragmentError(f"{what} has cases")
        n, d = cases[0].numerator, cases[0].denominator
        if d.constant:
            return n.scaled(1 / d.constant), ONE
        for sign in (Q(1), Q(-1)):
            if self._is_positive(d.scaled(sign), mode):
                return n.scaled(sign), d.scaled(sign)
        raise OutsideFragmentError(f"{what} has a divisor that may be 0")

    def _is_positive(self, p: Polynomial, mode: str) -> bool:
        """Whether it is above 0, as a positive number plus even powers, or by the ranges of params and the domain."""
        if all(c > 0 and all(e % 2 == 0 for _, e in m) for m, c in p.whole.items()) and () in p.whole:
            return True
        box: dict[str, tuple[Q, Q]] = dict(self.params)
        lows, highs = self._ends(mode)
        box |= {v: (lows[v], highs[v]) for v in lows.keys() & highs.keys() if lows[v] <= highs[v]}
        if set(p.variables) <= box.keys():
            return bounds(p, box)[0] > 0
        lows |= {n: low for n, (low, _) in self.params.items()}
        is_growing = all(c > 0 or not m for m, c in p.whole.items()) and all(lows.get(v, -1) >= 0 for v in p.variables)
        return is_growing and p.value(lows) > 0

    def _ends(self, mode: str) -> tuple[dict[str, Q], dict[str, Q]]:
        """The bounds that a domain gives to variables one by one."""
        lows, highs = dict[str, Q](), dict[str, Q]()
        for f in self.premises(self.formula(self.mode(mode).domain, mode, is_closed=True)).entries:
            if isinstance(f, Literal) and f.op in ("<", "<=") and f.polynomial.total_degree() == 1:
                (v, *others), terms = f.polynomial.variables, f.polynomial.terms
                if not others:
                    end = -terms.get((), Q(0)) / terms[((v, 1),)]
                    if terms[((v, 1),)] > 0:
                        highs[v] = min(highs.get(v, end), end)
                    else:
                        lows[v] = max(lows.get(v, end), end)
        return lows, highs

    def derivative(self, p: Polynomial, mode: str) -> Polynomial:
        """The derivative of a polynomial along the flow of a mode."""
        return self.functions.derivative(p, self.field(mode))

    def premises(self, *formulas: Formula) -> Premises:
        """A list of premises."""
        return Premises(self.functions).with_(*formulas)

    def common(self, name: str, after: Mapping[str, Polynomial] | None = None) -> list[Formula]:
        """What holds in a mode, whatever the invariant: the domain, assumptions, invariants used, ranges."""
        scope = self.scope(name, after)
        found = [self.formula(self.mode(name).domain, name, scope, is_closed=True)]
        if self.limit is not None and not self.claim.inductive:
            found.append(compare("<=", variable(TIME) - constant(self.limit)))
        assumed = (*self.spec.assumptions, *self.claim.assume)
        found += [denied(self.formula(Expr("not", (e,)), name, scope)) for e in assumed]
        found += [self.formula(e, name, scope) for e in self.using]
        for v in self.automaton.vars:
            if v.type != "real":
                low, high = self._type_range(v.type)
                value = scope.variables[v.name]
                found += [compare(">=", value - constant(low)), compare("<=", value - constant(high))]
        for n, (low, high) in self.params.items():
            if low < high:
                found += [compare(">=", variable(n) - constant(low)), compare("<=", variable(n) - constant(high))]
        for n, i in self.inputs.items():
            assert i.range is not None, "looked at before"
            found += [compare(">=", variable(n) - self.scope(name).polynomial(i.range.low))]
            found += [compare("<=", variable(n) - self.scope(name).polynomial(i.range.high))]
        return found

    def _type_range(self, type_: str) -> tuple[Q, Q]:
        values = self.values.positions[type_].values()
        return min(values), max(values)

    def starts(self, init: Init, mode: str) -> list[Formula]:
        """What an init line says of a start in a mode."""
        scope = self.scope(mode)
        given = [self.formula(init.where, mode, is_told=True)]
        for a in init.assigns:
            value = variable(a.var)
            ends = [(">=", a.to.low), ("<=", a.to.high)] if isinstance(a.to, Range) else [("==", a.to)]
            given += [compare(op, value - scope.polynomial(e)) for op, e in ends]
        said = conjunction(given)
        domain = self.formula(self.mode(mode).domain, mode, is_closed=True)
        bounded = set(self.functions.support(names_of(conjunction([said, domain]))))
        windows = [
            f for v in self.automaton.vars if v.type == "real" and v.name not in bounded for f in self.window(v.name)
        ]
        return [said, compare("==", variable(TIME)), *windows]

    def window(self, name: str) -> list[Formula]:
        """The declared range of a variable."""
        v = next(v for v in self.automaton.vars if v.name == name)
        if v.range is None:
            return []
        low, high = self.values.interval(v.range)
        return [compare(">=", variable(name) - constant(low)), compare("<=", variable(name) - constant(high))]

    def landing(self, k: int) -> dict[str, Polynomial]:
        """The values that an edge gives to variables, chosen ones under names of their own."""
        edge = self.automaton.edges[k]
        scope = self.scope(edge.source)
        chosen = {a.var: variable(f"{a.var}'") for a in edge.resets if isinstance(a.to, Range)}
        return chosen | {a.var: scope.polynomial(a.to) for a in edge.resets if isinstance(a.to, Expr)}

    def after(self, f: Formula, k: int) -> Formula:
        """A formula about the state after an edge, as one about the state before it."""
        return mapped(f, self.landing(k), self.functions)

    def jump(self, k: int) -> list[Formula]:
        """What holds when an edge is taken: before, the guard, the chosen values, after."""
        edge = self.automaton.edges[k]
        scope = self.scope(edge.source)
        chosen: list[Formula] = []
        for a in edge.resets:
            if isinstance(a.to, Range):
                value = variable(f"{a.var}'")
                chosen.append(compare(">=", value - scope.polynomial(a.to.low)))
                chosen.append(compare("<=", value - scope.polynomial(a.to.high)))
        after = self.common(edge.target, self.landing(k))
        return [*self.before(k), *chosen, *after]

    def before(self, k: int) -> list[Formula]:
        """What holds where an edge is taken, whatever it makes of the state."""
        edge = self.automaton.edges[k]
        guard = self.formula(edge.guard, edge.source, is_closed=edge.urgent, is_told=True)
        return [*self.common(edge.source), guard]

    def _undefined(self, known: Premises, mode: str, read: Iterable[Expr | Range]) -> tuple[Premises, ...]:
        """What is known, each time with one of the roots and logarithms that are read having no value.

        They are those of the expressions as written: what cancels is evaluated as well.
        """
        reading, found = Reading(mode, self.scope(mode), False, True), list[Formula]()
        for e in (end for to in read for end in ((to.low, to.high) if isinstance(to, Range) else (to,))):
            found += [self.formula(c, mode, is_told=True) for c in reading.defined(residual(e, Situation(mode)), set())]
        return tuple(known.with_(denied(f)) for f in dict.fromkeys(found) if f is not True)

    def lines(self) -> Iterator[tuple[Init, str, str]]:
        """Each init line with each mode it allows, and how this is called."""
        seen: dict[str, int] = {}
        for line in self.automaton.init:
            for m in [x.name for x in self.automaton.modes] if line.mode is None else [line.mode]:
                seen[m] = seen.get(m, 0) + 1
                yield line, m, m if seen[m] == 1 else f"{m} ({seen[m]})"

    def parts(self, formulas: Invariant) -> Iterator[Obligation]:
        """What has to be shown of an invariant, in order."""
        for line, m, where in self.lines():
            told = [*self.common(m), *self.starts(line, m), denied(formulas[m])]
            yield Obligation("init", where, m, self.premises(*told))
        names = edge_names(self.automaton.edges)
        for k, edge in enumerate(self.automaton.edges):
            wrong = denied(self.after(formulas[edge.target], k))
            told = [*self.jump(k), formulas[edge.source], wrong]
            before = self.premises(*self.before(k), formulas[edge.source])
            undefined = self._undefined(before, edge.source, (a.to for a in edge.resets))
            yield Obligation("edge", names[k], edge.source, self.premises(*told), None, k, undefined)
        for mode in self.automaton.modes:
            common = self.premises(*self.common(mode.name))
            undefined = self._undefined(common, mode.name, (line.rate for line in mode.flow))
            yield Obligation("flow", mode.name, mode.name, common, formulas[mode.name], None, undefined)
        for mode in self.automaton.modes if not self.claim.inductive else ():
            told = [*self.common(mode.name), formulas[mode.name], denied(self.aim(mode.name))]
            yield Obligation("use", mode.name, mode.name, self.premises(*told))


def names_of(f: Formula) -> set[str]:
    """The names in a formula."""
    return {v for leaf in literals(f) for v in leaf.polynomial.variables}
