"""The core as `.ha` text: everything written out, nothing left of the sugar.

Reading the text again gives the same core, but for `cells`: numbers of keyed tables are constants here.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

from haverify.elaborate.deep import deep_recursion
from haverify.elaborate.notation import Notation, quantity
from haverify.model.cellular import CellularAutomaton, Relation
from haverify.model.claim import Claim, Expectation, Goal
from haverify.model.fuzzy import FuzzyController, FuzzyInput
from haverify.model.hybrid import (
    Assign,
    Constant,
    Edge,
    HybridAutomaton,
    Init,
    Input,
    Mode,
    Output,
    Param,
    Priority,
    Range,
    Variable,
)
from haverify.model.spec import EnumType, Spec, UnitDef
from haverify.model.system import Part, Sync, System
from haverify.model.tables import DataTable, Network
from haverify.model.unit import Unit


def expand(spec: Spec) -> str:
    """The text of a spec's core."""
    with deep_recursion():
        return "\n".join(_Printer(spec).lines()) + "\n"


def _words(spec: Spec) -> dict[tuple[str, str], str]:
    """Each enumeration value, qualified where its name alone would mean something else."""
    owners: dict[str, int] = {}
    for enum in spec.enums:
        for value in enum.values:
            owners[value] = owners.get(value, 0) + 1
    taken = _declared(spec)
    return {
        (enum.name, v): v if owners[v] == 1 and v not in taken else f"{enum.name}.{v}"
        for enum in spec.enums if enum.low is None for v in enum.values
    }  # fmt: skip


def _declared(spec: Spec) -> set[str]:
    found: set[str] = {a.name for a in spec.automata}
    found.update(s.name for s in spec.systems)
    found.update(t.name for t in spec.tables)
    found.update(n.name for n in spec.networks)
    found.update(c.name for c in spec.cellular)
    found.update(r.name for r in spec.relations)
    found.update(f.name for f in spec.fuzzy)
    blocks: list[Spec | HybridAutomaton | System] = [spec, *spec.automata, *spec.systems]
    for block in blocks:
        found.update(c.name for c in block.constants)
        found.update(p.name for p in block.params)
        found.update(i.name for i in block.inputs)
        if not isinstance(block, Spec):
            found.update(v.name for v in block.vars)
            found.update(o.name for o in block.lets)
        if isinstance(block, HybridAutomaton):
            found.update(x.name for m in block.modes for x in m.lets)
        if isinstance(block, System):
            found.update(p.name for p in block.parts)
    return {name.split("[")[0] for name in found}


class _Printer:
    def __init__(self, spec: Spec) -> None:
        self.spec = spec
        self.write = Notation(_words(spec)).text

    def lines(self) -> Iterator[str]:
        spec = self.spec
        yield f'spec "{spec.name}" version "{spec.version}"{" unitless" if spec.unitless else ""}'
        yield from (self.unit(u) for u in spec.units)
        yield from (_enum(e) for e in spec.enums)
        yield from (_table(t) for t in spec.tables)
        yield from (_network(n) for n in spec.networks)
        yield from self.quantities(spec, "")
        yield from (f"assume {self.write(e)}" for e in spec.assumptions)
        for a in spec.automata:
            yield from self.automaton(a)
        for s in spec.systems:
            yield from self.system(s)
        for c in spec.cellular:
            yield from self.cellular(c)
        for r in spec.relations:
            yield from _relation(r)
        for f in spec.fuzzy:
            yield from self.fuzzy(f)
        for claim in spec.claims:
            yield from self.claim(claim)

    # ---- declarations

    def unit(self, u: UnitDef) -> str:
        if u.value is None:
            return f"unit {u.name}"
        q, k, dims = u.value
        text = str(q.numerator)
        text += " * pi" * k if k > 0 else " / pi" * -k
        for name, e in dims:
            text += f" {'*' if e > 0 else '/'} 1 {name}" * abs(int(e))
        return f"unit {u.name} = {text}" + (f" / {q.denominator}" if q.denominator != 1 else "")

    def quantities(self, block: Spec | HybridAutomaton | System, indent: str) -> Iterator[str]:
        yield from (indent + self.constant(c) for c in block.constants)
        yield from (indent + self.param(p) for p in block.params)
        yield from (indent + self.input(i) for i in block.inputs)

    def constant(self, c: Constant) -> str:
        rounding = f"@rounding({quantity(c.half, c.unit)[1]}) " if c.half is not None else ""
        value = self.range(c.value) if isinstance(c.value, Range) else self.write(c.value)
        return f"{rounding}const {c.name}{_type(c.type, c.unit)} = {value}"

    def param(self, p: Param) -> str:
        default = f" default {self.write(p.default)}" if p.default is not None else ""
        return f"param {p.name}{_type('real', p.unit)} in {self.range(p.range)}{default}"

    def input(self, i: Input) -> str:
        text = f"input {i.name}{_type(i.type, i.unit)}"
        text += f" in {self.range(i.range)}" if i.range else ""
        text += f" rate {self.range(i.rate)}" if i.rate else ""
        return text + (f" every {self.write(i.every)}" if i.every else "")

    def range(self, r: Range) -> str:
        return f"[{self.write(r.low)}, {self.write(r.high)}]"

    def variable(self, v: Variable) -> str:
        return f"var {v.name}{_type(v.type, v.unit)}" + (f" in {self.range(v.range)}" if v.range else "")

    def let(self, o: Output) -> str:
        return f"let {o.name}{_type(o.type, o.unit)} = {self.write(o.expr)}"

    def assigns(self, assigns: Sequence[Assign]) -> str:
        parts = [
            f"{a.var} in {self.range(a.to)}" if isinstance(a.to, Range) else f"{a.var} := {self.write(a.to)}"
            for a in assigns
        ]
        return "{ " + "; ".join(parts) + " }"

    def priority(self, p: Priority) -> str:
        when = f" when {self.write(p.when)}" if p.when.op != "true" else ""
        return f"priority {' over '.join(p.over)}{when}"

    def init(self, i: Init) -> str:
        text = "init" + (f" {i.mode}" if i.mode else "")
        text += f" where {self.write(i.where)}" if i.where.op != "true" else ""
        return text + (f" with {self.assigns(i.assigns)}" if i.assigns else "")

    # ---- automata and systems

    def automaton(self, a: HybridAutomaton) -> Iterator[str]:
        yield from _doc(a.doc)
        yield f"automaton {a.name} {{"
        yield from self.quantities(a, "  ")
        yield from ("  " + self.variable(v) for v in a.vars)
        yield from ("  " + self.let(o) for o in a.lets)
        yield from ("  " + self.init(i) for i in a.init)
        for m in a.modes:
            yield from self.mode(m)
        yield from ("  " + self.edge(e) for e in a.edges)
        yield from ("  " + self.priority(p) for p in a.priorities)
        yield "}"

    def mode(self, m: Mode) -> Iterator[str]:
        yield f"  mode {m.name} {{"
        if m.domain.op != "true":
            yield f"    domain {self.write(m.domain)}"
        yield from ("    " + self.let(o) for o in m.lets)
        if m.flow:
            lines = [
                f"{f.var}' in {self.range(f.rate)}" if isinstance(f.rate, Range) else f"{f.var}' = {self.write(f.rate)}"
                for f in m.flow
            ]
            yield "    flow { " + "; ".join(lines) + " }"
        if m.terminal:
            yield "    terminal"
        yield "  }"

    def edge(self, e: Edge) -> str:
        text = f"{'urgent ' if e.urgent else ''}edge {e.name}: {e.source} -> {e.target}"
        text += f" when {self.write(e.guard)}" if e.guard.op != "true" else ""
        return text + (f" do {self.assigns(e.resets)}" if e.resets else "")

    def system(self, s: System) -> Iterator[str]:
        yield from _doc(s.doc)
        yield f"system {s.name} {{"
        yield from self.quantities(s, "  ")
        yield from ("  " + self.variable(v) for v in s.vars)
        yield from ("  " + self.part(p) for p in s.parts)
        yield from ("  " + self.let(o) for o in s.lets)
        yield from ("  " + self.init(i) for i in s.init)
        if s.flow:
            yield "  flow { " + "; ".join(f"{v}' = {self.write(e)}" for v, e in s.flow) + " }"
        yield from ("  " + self.sync(y) for y in s.syncs)
        yield from ("  " + self.priority(p) for p in s.priorities)
        yield "}"

    def part(self, p: Part) -> str:
        bindings = [
            f"{b.name} in {self.range(b.to)}" if isinstance(b.to, Range) else f"{b.name} = {self.write(b.to)}"
            for b in p.bindings
        ]
        return f"part {p.name} = {p.of}" + (" with { " + "; ".join(bindings) + " }" if bindings else "")

    def sync(self, y: Sync) -> str:
        text = f"sync {y.name}: {', '.join(y.edges)}"
        text += f" -> {', '.join(y.listeners)}" if y.listeners else ""
        text += f" when {self.write(y.guard)}" if y.guard.op != "true" else ""
        return text + (f" do {self.assigns(y.resets)}" if y.resets else "")

    # ---- finite things

    def cellular(self, c: CellularAutomaton) -> Iterator[str]:
        yield from _doc(c.doc)
        yield f"cellular {c.name} {{"
        yield f"  cell {c.cell} = {c.first} ++ {c.second}"
        yield from (f"  rule 0b{r.left} -> 0b{r.right}" for r in c.rules)
        if c.formula is not None:
            yield f"  next({c.argument}) = {self.write(c.formula)}"
        yield "}"

    def fuzzy(self, f: FuzzyController) -> Iterator[str]:
        yield from _doc(f.doc)
        yield f"fuzzy {f.name} {{"
        yield from ("  " + _fuzzy_input(i) for i in f.inputs)
        yield from (f"  output {name} {{ {', '.join(terms)} }}" for name, terms in f.outputs)
        yield f"  logic {f.logic[0]} {f.logic[1]}"
        for r in f.rules:
            yield f"  rule {r.name + ': ' if r.name else ''}{self.write(r.premise)} => {r.output} is {r.term}"
        yield "}"

    # ---- claims

    def claim(self, c: Claim) -> Iterator[str]:
        yield from _doc(c.doc)
        on = f" on {c.on}" if c.on else ""
        if c.kind == "invariant":
            inductive = " inductive" if c.inductive else ""
            expect = f" {self.expect(c.expect)}" if c.expect else ""
            yield f"invariant {c.name}{on}: {self.write(c.goals[0].condition)}{inductive}{expect}"
            return
        yield f"property {c.name}{on} {{"
        yield from ("  " + line for line in self.claim_lines(c))
        yield "}"

    def claim_lines(self, c: Claim) -> Iterator[str]:
        yield from (f"assume {self.write(e)}" for e in c.assume)
        yield from (f"for which {n} in {self.range(r)}" for n, r in c.which)
        jumps = f"{c.jumps} jumps"
        if c.time is not None:
            yield f"within {self.write(c.time)}" + (f", {jumps}" if c.jumps is not None else "")
        elif c.jumps is not None:
            yield f"within {jumps}"
        if c.using:
            yield f"using {', '.join(c.using)}"
        if c.method is not None:
            yield _method(*c.method)
        yield from (self.goal(g) for g in c.goals)
        if c.expect is not None:
            yield self.expect(c.expect)

    def goal(self, g: Goal) -> str:
        within = f" within {self.write(g.within)}" if g.within is not None else ""
        text = self.write(g.condition)
        if g.kind == "always" and g.window is not None:
            return f"always during [{self.write(g.window[0])}, {self.write(g.window[1])}] {text}"
        words = {"can_reach": "can reach", "can_always": "can always", "cycle": "cycle through"}.get(g.kind, g.kind)
        return f"{words} {text}{within}" + (" attracting" if g.attracting else "")

    def expect(self, e: Expectation) -> str:
        text = f"expect {e.verdict}"
        text += f" margin {e.margin[0]} {self.write(e.margin[1])}" if e.margin else ""
        text += f" share {e.share[0]} {quantity(e.share[1], None)[1]}" if e.share else ""
        return text + (f' because "{e.because}"' if e.because is not None else "")


# ---- what holds no expression ---------------------------------------------------


def _type(type_: str, unit: Unit | None) -> str:
    if type_ != "real":
        return f": {type_}"
    if unit is None or not unit.is_writable or "%" in unit.text:
        return ""
    return f": {unit.text}"


def _doc(text: str) -> Iterator[str]:
    return (f"///{' ' if line and not line.startswith(' ') else ''}{line}" for line in text.split("\n") if text)


def _enum(e: EnumType) -> str:
    if e.low is not None and e.high is not None:
        return f"enum {e.name} = {e.low}..{e.high}"
    values = (v if c is None else f"{v} = {c}" for v, c in zip(e.values, e.codes, strict=True))
    return f"enum {e.name} {{ {', '.join(values)} }}"


def _table(t: DataTable) -> str:
    lines = [f"axis {n}{_type('real', u) or ': 1'}" for n, u in t.axes]
    for n, u, half in t.columns:
        width = half if isinstance(half, str) else quantity(half, u)[1] if half is not None else None
        lines.append(f"column {n}{_type('real', u) or ': 1'}" + (f" +- {width}" if width else ""))
    return f'table {t.name} from "{t.file}" {{ {"; ".join([*lines, f"interpolate {t.interpolate}"])} }}'


def _network(n: Network) -> str:
    lines = [f"input {k}{_type('real', u) or ': 1'}" for k, u in n.inputs]
    lines += [f"output {k}{_type('real', u) or ': 1'}" for k, u in n.outputs]
    lines += [f'sha256 "{n.sha256}"'] if n.sha256 is not None else []
    return f'network {n.name} from "{n.file}" {{ {"; ".join(lines)} }}'


def _relation(r: Relation) -> Iterable[str]:
    pairs = (f"  {a} -> {b}" if r.is_map else f"  ({a}, {b})" for a, b in r.pairs)
    return (*_doc(r.doc), f"relation {r.name} {{", *pairs, "}")


def _fuzzy_input(i: FuzzyInput) -> str:
    if i.source is not None:
        return f"input {i.name} from {i.source[0]}.{i.source[1]}"
    terms = (f"{t.name} = {t.shape}({', '.join(_q(c, i.unit) for c in t.corners)})" for t in i.terms)
    low, high = (_q(q, i.unit) for q in (i.low or Fraction(0), i.high or Fraction(0)))
    return f"input {i.name}{_type('real', i.unit)} over [{low}, {high}] {{ {', '.join(terms)} }}"


def _q(q: Fraction, unit: Unit | None) -> str:
    return quantity(q, unit)[1]


def _method(name: str, arguments: tuple[tuple[str, str], ...]) -> str:
    given = ", ".join(f"{k} = {v}" if k else v for k, v in arguments)
    return f"method {name}({given})" if given else f"method {name}"
