"""Formulas that hold at the start, are kept by edges and flows and imply a goal (docs/core.md section 9)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Any

from hacheck import bernstein
from hacheck.brackets import Brackets, brackets, rooted
from hacheck.cells import Model
from hacheck.expressions import EVENTS, Case, Instant, nodes
from hacheck.flows import Flow
from hacheck.formula import Formula, conj, disj, literal, negated, replace, variables
from hacheck.functions import Functions
from hacheck.obligations import canonical_hash, mentioned
from hacheck.polynomial import ONE, ZERO, Env, Poly, add, const, constant, mul, names, scale, var
from hacheck.positivity import Premises, on_box, polynomial, refute
from hacheck.rational import Beyond, Refused, number
from hacheck.scope import Scope

if TYPE_CHECKING:
    from hacheck.obligations import Question

Json = Any


class FlowScope(Scope):
    """A scope with functions of the state, and flows that are any polynomials; time is a name of its own."""

    has_functions = True

    def __init__(self, core: Any, automaton: Json) -> None:
        self.functions = Functions()
        super().__init__(core, automaton, False)
        self.inputs: dict[str, Json] = {i["name"]: i for i in [*core.data["inputs"], *automaton["inputs"]]}
        bad = any("'" in n or n in {*self.types, *self.ranges, "pi", "time"} for n in self.inputs)
        if bad or any(i["type"] != "real" or i["low"] is None or i["high"] is None for i in self.inputs.values()):
            raise Beyond("an input without two bounds, or with a name that means something else")
        if any(not set("(*+)").isdisjoint(n) for n in (*self.types, *self.ranges, *self.inputs)):
            raise Beyond("a name that could be that of a function, or a part of one")

    def function(self, op: str, a: Poly) -> Poly:
        return self.functions.apply(op, a)

    def input(self, name: str) -> Poly:
        if name not in self.inputs:
            raise Refused("there is no such input")
        return var(name)

    @property
    def rho(self) -> None:
        return None

    def rates(self, mode: str) -> dict[str, Poly]:
        raise Beyond("`der` in a claim about a flow that is not clock-driven")

    def field(self, mode: str) -> dict[str, Poly]:
        """The rate of each variable in a mode, and of time, all times what makes them polynomials and is above 0.

        That changes how fast runs go along their way, and not the way: what they keep is the same.
        """
        flow, at = self.modes[mode]["flow"], self.identity(mode)
        if not all("rate" in line for line in flow):
            raise Beyond("flows that are inclusions")
        found = {line["var"]: self._quotient(at.value(line["rate"]), mode) for line in flow}
        if len(found) != len(flow) or found.keys() != {v for v, kind in self.types.items() if kind == "real"}:
            raise Refused("a mode does not give each real variable one rate")
        divisors = list({_key(d): d for _, d in found.values() if d != ONE}.values())
        whole = {_key(d): _product(e for e in divisors if e != d) for d in divisors}
        clock = _product(divisors)
        return {v: mul(n, whole.get(_key(d), clock)) for v, (n, d) in found.items()} | {"time": clock}

    def _quotient(self, cases: list[Case], mode: str) -> tuple[Poly, Poly]:
        """The one value of a rate, its divisor above 0."""
        (no, n, d), *others = cases
        if others or no is not False:
            raise Beyond("a rate with cases")
        q = constant(d)
        if q:
            return scale(n, 1 / q), ONE
        for sign in (1, -1):
            if self._is_positive(scale(d, sign), mode):
                return scale(n, sign), scale(d, sign)
        raise Beyond("a rate with a divisor that may be 0")

    def _is_positive(self, p: Poly, mode: str) -> bool:
        """Is it above 0, as a positive number plus even powers, or in the domain, by the ranges of params?"""
        if all(c > 0 and all(m.count(n) % 2 == 0 for n in m) for m, c in p.terms.items()) and () in p.terms:
            return True
        inside = self.identity(mode).condition(self.modes[mode]["domain"], closed=True)
        ends = [literal(op, add(var(n), const(q), -1)) for n, i in self.box.items()
                for op, q in zip((">=", "<="), i, strict=True) if q is not None]  # fmt: skip
        return on_box(Premises(self.functions, [inside, *ends, literal("<=", p)]))


def _key(p: Poly) -> object:
    return frozenset(p.terms.items()), p.unit


def _product(factors: Iterable[Poly]) -> Poly:
    out = ONE
    for p in factors:
        out = mul(out, p)
    return out


class Induction:
    """A goal, the formulas of a certificate, and the parts that they come down to."""

    def __init__(self, question: Question, using: Json, modes: Json) -> None:
        self.question, self.claim, setting = question, question.claim, question.setting
        self.a, self.scope = setting.a, FlowScope(setting.core, setting.a)
        self.model = Model(self.scope)
        self.functions = self.scope.functions
        self.roots: Brackets = {}
        aim = question.goal["kind"]
        self.goal = question.condition if aim == "always" else ["not", question.condition]
        self.inductive = self.claim["inductive"]
        if self.inductive and (aim != "always" or modes is not None):
            raise Refused("an inductive claim is its own invariant")
        self.states = {*self.scope.types, *self.scope.ranges, "time", "pi"}
        self.used = [self._used(name) for name in using]
        conditions = [g["condition"] for g in self.used]
        if any(n[0] in EVENTS for n in nodes([self.goal, *question.assume, *conditions])):
            raise Beyond("an invariant about what just happened")
        said = [self.goal, *question.assume, *conditions, self.a["lets"], self.a["init"]]
        said += [part for m in self.a["modes"] for part in (m["domain"], m["lets"])]
        if any(n[0] == "input" for n in nodes(said)):  # what is known of states must not depend on them
            raise Beyond("an input elsewhere than in flows, guards and resets")
        for m in self.scope.modes:  # the functions that formulas may read are met
            _ = [*self.common(self.scope.identity(m)), self.scope.identity(m).formula(self.goal), self.scope.field(m)]
        self.formulas = {m: self._formula(m, modes) for m in self.scope.modes}
        for m in (m for m, mode in self.scope.modes.items() if mode["terminal"]):  # a run may be frozen there (S12)
            seen_there = conj([self.formulas[m], self.scope.identity(m).formula(self.goal)])
            if "time" in self.functions.support(variables(seen_there)):
                raise Beyond("time in a claim about a terminal mode")
        used = {"using": self.used} if self.used else {}
        seen = mentioned(setting.core, {**question.about, **used}, set())
        self.hash = canonical_hash({**question.about, **used, "constants": seen})

    def _used(self, name: Json) -> Json:
        """The goal of an invariant that the claim names, shown for all time, under what the claim assumes."""
        lemma = self.question.setting.lemma
        if not isinstance(name, str) or name not in self.claim["using"] or lemma is None:
            raise Refused("it uses what the claim does not name")
        found = lemma(name)
        goals, horizon = found["goals"], found["horizon"]
        timeless = len(goals) == 1 and goals[0]["kind"] == "always" and not goals[0]["window"]
        timeless = timeless and (horizon["time"], horizon["jumps"], goals[0]["within"]) == (None, None, None)
        same = found["on"] == self.claim["on"] and not found["which"]
        if not (timeless and same and all(e in self.claim["assume"] for e in found["assume"])):
            raise Refused(f"the invariant {name[:60]!a} says less than it is used for")
        return goals[0]

    def _formula(self, mode: str, given: Json) -> Formula:
        if given is None:
            return self.scope.identity(mode).formula(self.goal)
        return Flow(Premises(self.functions), {}, self.states).given(given[mode])

    def common(self, at: Instant) -> Iterator[Formula]:
        """What holds at an instant, whatever the invariant: the domain, assumptions, invariants used, ranges."""
        yield at.condition(self.scope.modes[str(at.mode)]["domain"], closed=True)
        limit = self.question.limit
        if limit is not None and not self.inductive:
            yield literal("<=", add(var("time"), const(limit), -1))
        yield from (negated(at.formula(e, True)) for e in self.question.assume)
        yield from (at.formula(g["condition"]) for g in self.used)
        yield from self.types(at)
        yield from self.param_ranges({})
        for name, i in self.scope.inputs.items():
            yield from (literal(op, add(var(name), self.scope.base.poly(i[end]), -1))
                        for op, end in ((">=", "low"), ("<=", "high")))  # fmt: skip

    def types(self, at: Instant) -> Iterator[Formula]:
        """Discrete variables have values of their types."""
        for v in self.a["vars"]:
            if v["type"] != "real":
                low, high = (const(number(e)) for e in self.scope.window(v))
                value = at.env[v["name"]]
                yield from (literal(">=", add(value, low, -1)), literal("<=", add(value, high, -1)))

    def keeps_types(self, before: Instant, after: Instant, *known: Formula) -> None:
        """An edge gives discrete variables values of their types; else the analysis ends where it does not (S4)."""
        landed = after.condition(self.scope.modes[str(after.mode)]["domain"], closed=True)
        taken, kept = conj([*self.common(before), *known, landed]), conj(self.types(after))
        shown = disj([negated(taken), kept])
        if kept != conj(self.types(before)) and not bernstein.shown(shown, self.scope.chosen, self.scope.whole):
            raise Beyond("an edge may give a discrete variable a value that its type does not have")

    def param_ranges(self, env: dict[str, Poly]) -> Iterator[Formula]:
        """Every param that is not one number is in its range."""
        for name, p in self.scope.ranges.items():
            value = env.get(name, self.scope.params[name])
            if name in env or value == var(name):
                for op, end in ((">=", "low"), ("<=", "high")):
                    bound = self.scope.base.poly(p[end])
                    yield literal(op, add(value, self.functions.substitute(bound, Env(env)), -1))

    def premises(self, *formulas: Formula) -> Premises:
        return Premises(self.functions, formulas)

    def starts(self, line: Json, at: Instant) -> Iterator[Formula]:
        """What an init line says of a start."""
        said = conj([at.condition(line["where"]), self.model.given(line["with"], at)])
        yield said
        yield literal("==", var("time"))
        domain = at.condition(self.scope.modes[str(at.mode)]["domain"], closed=True)
        bounded = set(self.functions.support(variables(conj([said, domain]))))
        for v in self.a["vars"]:
            if v["type"] == "real" and v["name"] not in bounded:
                yield from self.window(v, at)

    def window(self, v: Json, at: Instant) -> Iterator[Formula]:
        """The declared range of a variable."""
        for op, end in ((">=", v["low"]), ("<=", v["high"])):
            if end is not None:
                yield literal(op, add(at.env[v["name"]], at.poly(end), -1))

    def parts(self) -> Iterator[tuple[str, str, Any]]:
        """Kind and place of each part, and what checks its proof."""
        seen: dict[str, int] = {}
        for line in self.a["init"]:
            for m in self.scope.modes if line["mode"] is None else [line["mode"]]:
                seen[m] = seen.get(m, 0) + 1
                where = m if seen[m] == 1 else f"{m} ({seen[m]})"
                yield "init", where, lambda proof, m=m, line=line: self.init(m, line, proof)
        ends = [(e["source"], e["target"]) for e in self.a["edges"]]
        for k, (source, target) in enumerate(ends):
            name = f" ({self.a['edges'][k]['name']})" if ends.count(ends[k]) > 1 else ""
            yield "edge", f"{source} -> {target}{name}", lambda proof, k=k: self.edge(k, proof)
        yield from (("flow", m, lambda proof, m=m: self.flow(m, proof)) for m in self.scope.modes)
        if not self.inductive:
            yield from (("use", m, lambda proof, m=m: self.use(m, proof)) for m in self.scope.modes)

    def init(self, mode: str, line: Json, proof: Json) -> None:
        at = self.scope.identity(mode)
        refute(proof, self.premises(*self.common(at), *self.starts(line, at), negated(self.formulas[mode])))

    def edge(self, k: int, proof: Json) -> None:
        edge = self.a["edges"][k]
        before, after = self.scope.identity(edge["source"]), self.model.landing(k)
        guard = before.condition(edge["guard"], closed=edge["urgent"])
        taken = (*self.common(before), guard, self.formulas[edge["source"]])
        self.defined(before, [r[end] for r in edge["resets"] for end in ("to", "low", "high") if end in r], taken)
        chosen = self.model.given(self.model.sets(k), before, "'")
        self.keeps_types(before, after, guard, chosen, self.formulas[edge["source"]])
        env = Env(after.env)
        target = replace(self.formulas[edge["target"]], lambda op, p: literal(op, self.functions.substitute(p, env)))
        refute(proof, self.premises(*self.common(before), guard, chosen, *self.common(after),
                                    self.formulas[edge["source"]], negated(target)))  # fmt: skip

    def undefined(self, at: Instant, read: Json, known: Iterable[Formula]) -> Iterator[Premises]:
        """What is known, each time with a root or a logarithm of some expressions, as written, without a value (S1)."""
        told = list(known)
        return (self.premises(*told, negated(f)) for f in at.partial(read, set()) if f is not True)

    def defined(self, at: Instant, read: Json, known: Iterable[Formula]) -> None:
        """Refuse unless all that is evaluated has a value."""
        if not all(map(on_box, self.undefined(at, read, known))):
            raise Refused("a jump or a flow reads a root or a logarithm that may not be defined")

    def flow(self, mode: str, proof: Json) -> None:
        at, rates = self.scope.identity(mode), self.scope.field(mode)
        self.defined(at, [line["rate"] for line in self.scope.modes[mode]["flow"]], self.common(at))
        flow = Flow(self.premises(*self.common(at)), rates, self.states, bool(self.scope.inputs))
        flow.kept(proof, [self.formulas[mode]], self.formulas[mode])

    def use(self, mode: str, proof: Json) -> None:
        at = self.scope.identity(mode)
        refute(proof, self.premises(*self.common(at), self.formulas[mode], negated(at.formula(self.goal))))

    def start(self, start: Json, wrong: bool = False) -> None:
        """The start given is admissible: nothing is proved of nothing.

        It violates the goal, if that is said, perhaps after jumps at once, and for all values of params left out.
        """
        mode, given = str(start["mode"]), set(start["params"])
        if not (given == set(self.scope.ranges) or (wrong and given < set(self.scope.ranges))):
            raise Refused("a start does not give every param a value")
        if set(start["values"]) != set(self.scope.types):
            raise Refused("a start does not give every variable a value")
        at = self.scope.identity(mode)
        lines = [line for line in self.a["init"] if line["mode"] in (None, mode)]
        told = [list(self.starts(line, at)) for line in lines]  # the functions that values may read are met
        self.roots = brackets(start["values"], self.scope.types)
        numbers = {**start["params"], **{v: q for v, q in start["values"].items() if v not in self.roots}}
        known = {n: self.value(q) for n, q in numbers.items()}
        free = {i: self.scope.base.poly(x["low"]) for i, x in self.scope.inputs.items()}  # any value they may have
        fixed = Env(known)
        env = Env({**known, **{i: self.functions.substitute(p, fixed) for i, p in free.items()}, "time": ZERO})
        said = [conj([*f, *self.arrived(mode, env, wrong)]) for f in told]
        if not any(self.here(f, env, True) for f in said):
            raise Refused("a start is not admissible, or does not violate the goal")
        for step in start.get("jumps", []):
            if self.roots:
                raise Beyond("jumps from a start that is bracketed")
            mode, env = self.jumped(mode, env, step)
        if wrong and not self.here(self.scope.identity(mode).formula(self.goal, True), env):
            raise Refused("a start is not admissible, or does not violate the goal")

    def value(self, given: Json) -> Poly:
        """A value of a start: a number, or a POLY in functions of numbers, which are defined."""
        if isinstance(given, str):
            return const(number(given))
        p = polynomial(given)
        closed = set(names(p)) <= {*self.functions.known, "pi"} and set(self.functions.support(names(p))) <= {"pi"}
        defined = conj(literal(">", a) for _, a in self.functions.partial(p))
        if not closed or not on_box(self.premises(negated(defined))):
            raise Refused("a value of a start is no number")
        return p

    def arrived(self, mode: str, env: Env, wrong: bool) -> Iterator[Formula]:
        """What every state of a run has to be: as in all modes, in ranges, as is assumed; `wrong`: all is defined."""
        discrete = [constant(env[v]) for v, kind in self.scope.types.items() if kind != "real"]
        if any(q is None or q.denominator != 1 for q in discrete):
            raise Refused("a start gives a variable a value that its type does not have")
        at = self.scope.identity(mode)
        yield from self.common(at)
        yield from (f for v in self.a["vars"] for f in self.window(v, at) if v["type"] == "real")
        yield from (at.formula(e) for e in self.question.assume)
        for name in list(self.functions.known) if wrong else ():
            yield from (literal("!=" if op == "inv" else ">=" if op == "sqrt" else ">", a)
                        for op, a in self.functions.partial(var(name)))  # fmt: skip
        yield from self.param_ranges({n: p for n, p in env.items() if n in self.scope.ranges})

    def here(self, f: Formula, env: Env, rooting: bool = False) -> bool:
        """Does a formula certainly hold with these values, whatever params left out are (around their range)?

        The same of values in brackets; `rooting`: of those that are the zeros of the formula's equations.
        """
        put = replace(f, lambda op, p: literal(op, self.functions.substitute(p, env)))
        put = rooted(put, self.roots) if rooting and self.roots else put
        if put is None:
            return False
        out = {n: self.scope.box[n] for n in sorted(self.scope.params.keys() - env.keys())} | self.roots
        known = [literal(op, add(var(n), const(q), -1)) for n, ends in out.items()
                 for op, q in zip((">=", "<="), ends, strict=True) if q is not None]  # fmt: skip
        return on_box(self.premises(*known, negated(put)))

    def jumped(self, mode: str, env: Env, step: Json) -> tuple[str, Env]:
        """The state after a jump that a run can make at once."""
        k = step["edge"]
        if type(k) is not int or k not in self.model.leaving[mode]:
            raise Refused("a run takes an edge that its mode does not have")
        sets, before, after = self.model.sets(k), self.scope.identity(mode), self.model.landing(k)
        if set(step["values"]) != {r["var"] for r in sets}:
            raise Refused("a run does not choose the values that its edge leaves open")
        now = Env({**env, **{v + "'": const(number(q)) for v, q in step["values"].items()}})
        taken = conj([before.condition(self.a["edges"][k]["guard"]), self.model.given(sets, before, "'")])
        landed = Env({**env, **{v: self.functions.substitute(p, now) for v, p in after.env.items()}})
        if not (self.here(taken, now) and self.here(conj(self.arrived(str(after.mode), landed, True)), landed)):
            raise Refused("a run takes an edge that it cannot take")
        return str(after.mode), landed


def shown(question: Question, entry: Json) -> tuple[str, list[tuple[str, str, str]]]:
    """What an entry of kind `invariant` establishes."""
    if question.goal["kind"] not in ("always", "can_reach"):
        raise Beyond("an invariant for another goal")
    if question.scope.rounding:
        raise Beyond("an invariant for all numbers that round to those printed")
    if entry["kind"] == "start":
        return _at_start(question, entry)
    induction, found = Induction(question, entry["using"], entry["modes"]), []
    induction.start(entry["start"])
    expected = list(induction.parts())
    if len(expected) != len(entry["parts"]):
        raise Refused("the invariant comes down to another number of parts")
    for (kind, where, check), part in zip(expected, entry["parts"], strict=True):
        if (part["kind"], part["where"]) != (kind, where):
            raise Refused(f"the certificate has another part than {kind} {where}")
        question.same(part, kind, where, "", induction.hash)
        try:
            check(part["proof"])
        except Refused as e:
            raise type(e)(f"{kind} {where}: {e}") from None
        found.append((f"{kind} {where}", "", "proved"))
    return ("proved" if question.goal["kind"] == "always" else "refuted"), found


def _at_start(question: Question, entry: Json) -> tuple[str, list[tuple[str, str, str]]]:
    """A goal that an admissible start violates at once."""
    if question.after is not None and question.after > 0:
        raise Refused("the claim does not speak of the start")
    if question.jumps is not None and len(entry["start"].get("jumps", [])) > question.jumps:
        raise Refused("a run makes more jumps than the claim speaks of")
    mode = entry["start"]["mode"]
    question.same(entry, "start", mode, "")
    Induction(question, [], None).start(entry["start"], True)
    verdict = "refuted" if question.goal["kind"] == "always" else "proved"
    return verdict, [(mode, "", verdict)]
