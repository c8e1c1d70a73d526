"""A spec in which a system is one automaton, with the claims on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from haverify.analyses.networks.product import Product
from haverify.model.spec import Spec
from haverify.text.record import replace


def whole_of(spec: Spec, name: str, core: Mapping[str, Any]) -> Spec:
    """The spec with one automaton, that which the system is, and with the claims on it.

    Raises
    ------
    OutsideFragmentError    if the system is not to be put together
    """
    whole = Product(spec, core, name)
    claims = tuple(whole.claim(c) for c in spec.claims if c.on == name)
    return replace(spec, automata=(whole.automaton(with_lets=False),), systems=(), claims=claims)
