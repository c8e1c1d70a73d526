"""Declarations as lines of text: what is written before a block, and the lines inside it."""

from __future__ import annotations

from collections.abc import Sequence

from haverify.syntax import tree
from haverify.syntax.expressions import print_expr, print_family
from haverify.text.record import record
from haverify.text.span import Span


@record
class Line:
    """`head`, or `head { inner }` when `inner` is not None; `above` are doc comments and attributes."""

    head: str
    span: Span
    inner: tuple[Line, ...] | None = None
    separator: str = "; "
    above: tuple[str, ...] = ()


def item_line(item: tree.Item) -> Line:
    """The line of a declaration, a member or a property line."""
    above = [f"/// {doc}".rstrip() for doc in item.docs] + [_attribute(attribute) for attribute in item.attributes]
    body = _body(item.body)
    return Line(body.head, item.span, body.inner, body.separator, tuple(above))


def _attribute(attribute: tree.Attribute) -> str:
    return f"@{attribute.name}" + _arguments(attribute.arguments)


def _arguments(arguments: Sequence[tree.AttributeArgument]) -> str:
    return f"({', '.join(_argument(argument) for argument in arguments)})" if arguments else ""


def _argument(argument: tree.AttributeArgument) -> str:
    value = f'"{argument.value}"' if isinstance(argument.value, str) else print_expr(argument.value)
    return f"{argument.name} = {value}" if argument.name else value


def _block(head: str, span: Span, items: Sequence[tree.Item]) -> Line:
    return Line(head, span, tuple(item_line(item) for item in items))


def _body(body: tree.Decl) -> Line:
    for part in (_file_line, _data_line, _automaton_line, _system_line, _finite_line, _claim_line):
        line = part(body)
        if line is not None:
            return line
    raise TypeError(f"not a declaration: {body!r}")


# ---- pieces ----------------------------------------------------------------------


def _after(word: str, expr: tree.Expr | None) -> str:
    return f" {word} {print_expr(expr)}" if expr is not None else ""


def _type(of: tree.Type | None) -> str:
    return f": {of.text}" if of else ""


def _declared(declared: tree.Declared) -> str:
    index = f"[{declared.index}]" if declared.index is not None else ""
    return declared.name + index + print_family(declared.family)


def _target(target: tree.Target) -> str:
    return target.name + (f"[{print_expr(target.index)}]" if target.index is not None else "")


def _assignment(assignment: tree.Assignment) -> Line:
    sign = "in" if assignment.is_set else ":="
    text = f"{_target(assignment.target)} {sign} {print_expr(assignment.value)}{print_family(assignment.family)}"
    return Line(text, assignment.span)


def _derivative(line: tree.Derivative) -> Line:
    sign = "in" if line.is_set else "="
    text = f"{_target(line.target)}' {sign} {print_expr(line.value)}{print_family(line.family)}"
    return Line(text, line.span)


def _binding(binding: tree.Binding) -> Line:
    sign = "in" if binding.is_set else "="
    return Line(f"{binding.name} {sign} {print_expr(binding.value)}", binding.span)


def _with_assignments(head: str, word: str, assignments: Sequence[tree.Assignment], span: Span) -> Line:
    """One assignment stands on the line, several in a block."""
    if not assignments:
        return Line(head, span)
    lines = tuple(_assignment(assignment) for assignment in assignments)
    if len(lines) == 1:
        return Line(f"{head} {word} {lines[0].head}", span)
    return Line(f"{head} {word}", span, lines)


# ---- declarations --------------------------------------------------------------------


def _file_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.SpecHeader():
            unitless = " unitless" if body.unitless else ""
            return Line(f'spec "{body.title}" version "{body.version}"{unitless}', body.span)
        case tree.Import():
            return Line(f'import "{body.path}"' + (f" as {body.alias}" if body.alias else ""), body.span)
        case tree.UnitDecl():
            return Line(f"unit {body.name}" + _after("=", body.value), body.span)
        case tree.Const():
            return Line(f"const {_declared(body.declared)}{_type(body.type)} = {print_expr(body.value)}", body.span)
        case tree.Param():
            default = _after("default", body.default)
            head = f"param {_declared(body.declared)}{_type(body.type)} in {print_expr(body.range)}{default}"
            return Line(head, body.span)
        case tree.Input():
            bounds = _after("in", body.range) + _after("rate", body.rate) + _after("every", body.every)
            return Line(f"input {_declared(body.declared)}{_type(body.type)}{bounds}", body.span)
        case tree.Function():
            formals = ", ".join(formal.name + _type(formal.type) for formal in body.formals)
            return Line(f"fn {body.name}({formals}){_type(body.type)} = {print_expr(body.value)}", body.span)
    return None


def _data_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.EnumDecl():
            if body.low is not None and body.high is not None:
                return Line(f"enum {body.name} = {print_expr(body.low)}..{print_expr(body.high)}", body.span)
            values = (Line(v.name + (f" = {v.code}" if v.code else ""), v.span) for v in body.values)
            return Line(f"enum {body.name}", body.span, tuple(values), ", ")
        case tree.Table():
            lines = tuple(Line(_table_line(line), line.span) for line in body.lines)
            return Line(f'table {body.name} from "{body.path}"', body.span, lines)
        case tree.Network():
            lines = tuple(Line(_network_line(line), line.span) for line in body.lines)
            return Line(f'network {body.name} from "{body.path}"', body.span, lines)
    return None


def _table_line(line: tree.TableLine) -> str:
    match line.kind:
        case "key":
            return f"key {line.name}: {line.of}"
        case "poly":
            argument = f"{line.argument}{_type(line.type)} -> {line.result}"
            return f"poly {line.name}..{line.last} {line.order} in {argument}"
        case "axis":
            return f"axis {line.name}{_type(line.type)}"
        case "column":
            return f"column {line.name}{_type(line.type)}{_after('+-', line.tolerance)}"
        case "matrix":
            return f"matrix {line.of} by {line.by}{_type(line.type)}"
        case "digits" if line.number is not None:
            return f"digits {print_expr(line.number)}"
        case "sha256":
            return f'sha256 "{line.text}"'
    return f"{line.kind} {line.name}"


def _network_line(line: tree.NetworkLine) -> str:
    if line.declared is None:
        return f'sha256 "{line.text}"'
    return f"{line.kind} {_declared(line.declared)}{_type(line.type)}"


def _automaton_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.Automaton():
            return _block(f"automaton {body.name}", body.span, body.members)
        case tree.Instance():
            bindings = tuple(_binding(binding) for binding in body.bindings)
            return Line(f"automaton {body.name} = {print_expr(body.base)} with", body.span, bindings)
        case tree.Var():
            names = ", ".join(_declared(tree.Declared(n.name, n.index, None, n.span)) for n in body.names)
            family = print_family(body.names[0].family)
            return Line(f"var {names}{family}{_type(body.type)}{_after('in', body.range)}", body.span)
        case tree.Let():
            return Line(f"let {_declared(body.declared)}{_type(body.type)} = {print_expr(body.value)}", body.span)
        case tree.Mode():
            return _block(f"mode {_declared(body.declared)}", body.span, body.members)
        case tree.Domain():
            return Line(f"domain {print_expr(body.condition)}", body.span)
        case tree.Terminal():
            return Line("terminal", body.span)
        case tree.Flow():
            return Line("flow", body.span, tuple(_derivative(line) for line in body.lines))
    return _jump_line(body)


def _jump_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.Init():
            head = "init" + (f" {_target(body.mode)}" if body.mode else "") + _after("where", body.where)
            return _with_assignments(head, "with", body.assignments, body.span)
        case tree.Edge():
            head = ("urgent edge" if body.urgent else "edge") + (
                f" {_declared(body.declared)}:" if body.declared else ""
            )
            source = f" {_target(body.source)}" if body.source else ""
            head += f"{source} -> {_target(body.target)}{_after('when', body.guard)}"
            return _with_assignments(head, "do", body.assignments, body.span)
        case tree.Sample():
            head = f"sample {body.name} every {print_expr(body.period)}"
            return _with_assignments(head, "do", body.assignments, body.span)
        case tree.Schedule():
            slots = tuple(_slot(slot) for slot in body.slots)
            return Line(f"schedule on {body.clock} from {print_expr(body.start)}", body.span, slots)
        case tree.Priority():
            paths = " over ".join(print_expr(path) for path in body.paths)
            return Line(f"priority {paths}{_after('when', body.guard)}", body.span)
    return None


def _slot(slot: tree.Slot) -> Line:
    head = f"{slot.mode} until {print_expr(slot.until)}" + (f" then {slot.then}" if slot.then else "")
    return _with_assignments(head, "do", slot.assignments, slot.span)


def _system_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.System() if body.parts:
            parts = " || ".join(print_expr(part) for part in body.parts)
            syncs = f" sync {', '.join(body.syncs)}" if body.syncs else ""
            return Line(f"system {body.name} = {parts}{syncs}", body.span)
        case tree.System():
            return _block(f"system {body.name}", body.span, body.members)
        case tree.Part():
            head = f"part {_declared(body.declared)} = {print_expr(body.base)}"
            bindings = tuple(_binding(binding) for binding in body.bindings)
            return Line(f"{head} with", body.span, bindings) if bindings else Line(head, body.span)
        case tree.Sync():
            paths = ", ".join(print_expr(path) for path in body.paths)
            listeners = " -> " + ", ".join(print_expr(path) for path in body.listeners) if body.listeners else ""
            head = f"sync {_declared(body.declared)}: {paths}{listeners}{_after('when', body.guard)}"
            return _with_assignments(head, "do", body.assignments, body.span)
    return None


def _finite_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.Cellular():
            return Line(f"cellular {body.name}", body.span, tuple(_cellular_line(line) for line in body.lines))
        case tree.Relation():
            return Line(f"relation {body.name}", body.span, tuple(_relation_line(line) for line in body.lines))
        case tree.Fuzzy():
            return Line(f"fuzzy {body.name}", body.span, tuple(_fuzzy_line(line) for line in body.lines))
    return None


def _cellular_line(line: tree.CellLine | tree.RuleLine | tree.NextLine) -> Line:
    match line:
        case tree.CellLine():
            return Line(f"cell {line.name} = {line.first} ++ {line.second}", line.span)
        case tree.NextLine():
            return Line(f"next({line.name}) = {print_expr(line.value)}", line.span)
    return Line(f"rule {print_expr(line.left)} -> {print_expr(line.right)}", line.span)


def _relation_line(line: tree.RuleLine) -> Line:
    left, right = print_expr(line.left), print_expr(line.right)
    return Line(f"({left}, {right})" if line.is_pair else f"{left} -> {right}", line.span)


def _fuzzy_line(line: tree.FuzzyLine) -> Line:
    match line.kind:
        case "input":
            head = f"input {line.name}{_type(line.type)}{_after('over', line.range)}"
            return Line(head, line.span, tuple(_term(term) for term in line.terms))
        case "chain":
            return Line(f"input {line.name} from {line.source}.{line.output}", line.span)
        case "output":
            return Line(f"output {line.name} {{ {', '.join(line.values)} }}", line.span)
        case "logic":
            return Line(f"logic {' '.join(line.values)}", line.span)
    label = f" {line.name}:" if line.name else ""
    assert line.condition is not None  # every rule has one
    return Line(f"rule{label} {print_expr(line.condition)} => {line.output} is {line.values[0]}", line.span)


def _term(term: tree.FuzzyTerm) -> Line:
    return Line(f"{term.name} = {term.shape}({', '.join(print_expr(corner) for corner in term.corners)})", term.span)


# ---- claims ------------------------------------------------------------------------------


def _claim_line(body: tree.Decl) -> Line | None:
    match body:
        case tree.Property():
            on = _after("on", body.on)
            return _block(f"property {_declared(body.declared)}{on}", body.span, body.lines)
        case tree.Invariant():
            place = _after("on", body.on) + (f" in {_target(body.mode)}" if body.mode else "")
            end = (" inductive" if body.inductive else "") + (f" {_expectation(body.expect)}" if body.expect else "")
            return Line(f"invariant {_declared(body.declared)}{place}: {print_expr(body.condition)}{end}", body.span)
        case tree.Assume():
            label = f" {body.name}:" if body.name else ""
            return Line(f"assume{label} {print_expr(body.condition)}", body.span)
        case tree.Which():
            return Line(f"for which {body.name} in {print_expr(body.range)}", body.span)
        case tree.Using():
            return Line(f"using {', '.join(name.id for name in body.names)}", body.span)
        case tree.Method():
            return Line(f"method {body.name}{_arguments(body.arguments)}", body.span)
        case tree.Horizon():
            return Line(_horizon(body), body.span)
        case tree.Goal():
            return Line(_goal(body), body.span)
        case tree.Expectation():
            return Line(_expectation(body), body.span)
    return None


def _horizon(body: tree.Horizon) -> str:
    jumps = f"{print_expr(body.jumps)} jumps" if body.jumps else ""
    time = print_expr(body.time) if body.time is not None else ""
    return "within " + ", ".join(part for part in (time, jumps) if part)


def _goal(goal: tree.Goal) -> str:
    words = {"can_reach": "can reach", "can_always": "can always", "cycle": "cycle through"}
    text = words.get(goal.kind, goal.kind)
    if goal.window:
        text += f" during [{print_expr(goal.window[0])}, {print_expr(goal.window[1])}]"
    return f"{text} {print_expr(goal.condition)}{_after('within', goal.within)}" + " attracting" * goal.attracting


def _expectation(expect: tree.Expectation) -> str:
    text = f"expect {expect.verdict}"
    for word, bound in (("margin", expect.margin), ("share", expect.share)):
        if bound:
            text += f" {word} {bound[0]} {print_expr(bound[1])}"
    return text + (f' because "{expect.because}"' if expect.because is not None else "")
