"""A spec in which a system is one automaton, with the claims on it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from haverify.analyses.networks.product import Product
from haverify.model.claim import Claim
from haverify.model.spec import Spec
from haverify.text.record import replace


def whole_of(
    spec: Spec, name: str, core: Mapping[str, Any], left: Iterable[str] | None = None, everywhere: bool = False
) -> Spec:
    """The spec with one automaton, that which the system is, and with the claims on it.

    `left` are the modes whose edges are listed, None for all. Modes that no edge leads to are there if `everywhere`.

    Raises
    ------
    OutsideFragmentError    if the system is not to be put together
    """
    whole = Product(spec, core, name, None if left is None else frozenset(left), everywhere=everywhere)
    return told(whole, [c for c in spec.claims if c.on == name])


def told(whole: Product, claims: Iterable[Claim]) -> Spec:
    """The spec with the automaton that a system was put together to, and with some claims on it."""
    found = tuple(whole.claim(c) for c in claims)
    return replace(whole.spec, automata=(whole.automaton(with_lets=False),), systems=(), claims=found)
