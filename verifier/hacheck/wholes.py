"""Claims about a system as claims about the automaton that it is, under the rules for automata."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hacheck.composed import Composed
from hacheck.rational import Beyond, Refused

if TYPE_CHECKING:
    from hacheck.obligations import Setting
    from hacheck.systems import SystemCheck

Json = Any
ALONG = ("flowpipe", "flow_run")


class Whole:
    """The automaton of a system; `given` is true, or names the modes whose edges a certificate needs.

    It has the modes that no edge leads to if `everywhere`, which claims that are `inductive` ask for (S22).
    """

    def __init__(self, check: SystemCheck, given: Json, everywhere: bool) -> None:
        from hacheck.obligations import Setting

        if given is not True and not (isinstance(given, list) and all(isinstance(n, str) for n in given)):
            raise Refused("a certificate does not say which modes of a system it is about")
        self.name, self.lemma = check.system["name"], check.lemma
        if everywhere and given is not True:
            raise Refused("modes are left out of what is claimed to be inductive")
        self.composed = Composed(check.core, check.system, None if given is True else frozenset(given), everywhere)
        check.core.check_automaton(self.composed.automaton)
        self.setting = Setting(check.core, self.composed.automaton, False, check.load, self._used)
        self.setting.model.scope.open = self.composed.open

    def question(self, claim: Json, certificate: Json) -> tuple[Json, Json, Setting]:
        """A claim on the automaton, and what is to show it."""
        if claim["which"] or certificate["rounding"] is not None:
            raise Beyond("`for which`, or what rounding does, in claims about systems put together")
        if self.composed.open and any(e and e.get("kind") not in ALONG for e in certificate["goals"]):
            raise Refused("only what goes along flows may leave modes of a system out")
        return self.composed.claim(claim), certificate, self.setting

    def _used(self, name: str) -> Json:
        """A claim on the same system that is proved, as one on its automaton."""
        found = None if self.lemma is None else self.lemma(name)
        if found is None or found["on"] != self.name:
            raise Refused("an invariant of something else is used")
        return self.composed.claim(found)
