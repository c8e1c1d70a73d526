"""Obligations: the hash that ties a part's proof to the model and the claim it is about (docs/core.md section 4)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from hashlib import sha256
from typing import Any

from haverify.model.claim import Claim, Goal
from haverify.model.core import automaton_to_json, canonical, expr_to_json, goal_to_json, horizon_to_json, to_core
from haverify.model.hybrid import HybridAutomaton
from haverify.model.spec import Spec
from haverify.text.record import holder

Json = Any


@holder
class Hashes:
    """The obligation hashes of claims on one automaton; what they share is computed once."""

    spec: Spec
    automaton: HybridAutomaton
    core: Mapping[str, Json]

    @cached_property
    def constants(self) -> dict[str, Json]:
        """The top-level constants by name."""
        return {c["name"]: c for c in self.core["constants"]}

    @cached_property
    def model(self) -> str:
        """M: everything about the automaton that a verdict may rest on."""
        listed = (a for a in self.core["automata"] if a["name"] == self.automaton.name)
        automaton = next(listed, None) or automaton_to_json(self.automaton)
        params, assumptions = self.core["params"], self.core["assumptions"]
        value = {
            "automaton": automaton,
            "constants": self.mentioned(automaton, frozenset(c.name for c in self.automaton.constants)),
            "params": params,
            "enums": self.core["enums"],
            "assumptions": assumptions,
        }
        return digest(value)

    def goal(self, claim: Claim, goal: Goal, using: Iterable[Goal] = ()) -> str:
        """G: the goal with its horizon, assumptions and, for invariants, the goals of those it uses."""
        assume = [expr_to_json(e) for e in claim.assume]
        value = {"goal": goal_to_json(goal), "horizon": horizon_to_json(claim), "assume": assume}
        used = [goal_to_json(g) for g in using]
        value |= {"using": used} if used else {}
        return digest({**value, "constants": self.mentioned(value)})

    def part(self, goal: str, kind: str, where: str, output: str) -> str:
        """The hash of one part."""
        return digest(["haverify.obligation/1", self.model, goal, kind, where, output])

    def mentioned(self, value: Json, hidden: frozenset[str] = frozenset()) -> list[Json]:
        """The top-level constants that a JSON value mentions, transitively, in the order of the core.

        A `hidden` name means something else in the value itself.
        """
        found: set[str] = set()
        queue = [n for n in _constant_names(value) if n in self.constants and n not in hidden]
        while queue:
            name = queue.pop()
            if name not in found:
                found.add(name)
                queue += [n for n in _constant_names(self.constants[name]["value"]) if n in self.constants]
        if len(found) < 8:
            return sorted((self.constants[n] for n in found), key=lambda c: self._order[c["name"]])
        return [c for name, c in self.constants.items() if name in found]

    @cached_property
    def _order(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.constants)}


TIMELESS = ("constants", "params", "enums", "assumptions", "cellular", "relations", "fuzzy", "tables")


def goal_digest(core: Mapping[str, Json], claim: Claim, goal: Goal) -> str:
    """The hash of a goal without time (docs/core.md section 6)."""
    assume = [expr_to_json(e) for e in claim.assume]
    return digest(["haverify.obligation/1", {k: core[k] for k in TIMELESS}, goal_to_json(goal), assume, claim.on])


def hashes(spec: Spec, automaton: HybridAutomaton, core: Mapping[str, Json] | None = None) -> Hashes:
    """The hashes of claims on `automaton`; `core` is the spec's core, where it is at hand."""
    return Hashes(spec, automaton, core if core is not None else to_core(spec))


def digest(value: Json) -> str:
    """SHA-256 of the canonical JSON without its final newline."""
    return sha256(canonical(value)[:-1]).hexdigest()


def _constant_names(value: Json) -> Iterable[str]:
    """The names in `["const", name]` nodes anywhere in a JSON value."""
    stack = [value]
    while stack:
        node = stack.pop()
        if isinstance(node, dict):
            stack.extend(node.values())
        elif isinstance(node, (list, tuple)):
            if len(node) == 2 and node[0] == "const" and isinstance(node[1], str):
                yield node[1]
            else:
                stack.extend(node)
