"""Which module enters which declaration that is no hybrid automaton."""

from __future__ import annotations

from haverify.elaborate.cellular import enter_cellular, enter_relation
from haverify.elaborate.declare import Entries
from haverify.elaborate.fuzzy import enter_fuzzy
from haverify.elaborate.network import enter_network
from haverify.syntax import tree as t


def enter_finite(entries: Entries, item: t.Item, path: str) -> None:
    """Enter a cellular automaton, relation, fuzzy system or network."""
    body = item.body
    if isinstance(body, t.Cellular):
        enter_cellular(entries, item, body)
    elif isinstance(body, t.Relation):
        enter_relation(entries, item, body)
    elif isinstance(body, t.Fuzzy):
        enter_fuzzy(entries, item, body)
    elif isinstance(body, t.Network):
        enter_network(entries, body, path)
