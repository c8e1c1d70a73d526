"""Attributes in front of declarations: `@allow(HA401, reason = "...")`."""

from __future__ import annotations

from collections.abc import Iterator

from haverify.model.spec import Allowed
from haverify.syntax import tree as t


def allowances(item: t.Item) -> Iterator[Allowed]:
    """The `@allow` of an item and of its members."""
    for attribute in item.attributes:
        if attribute.name == "allow":
            yield from _allowed(attribute, item)
    for member in (*getattr(item.body, "members", ()), *getattr(item.body, "lines", ())):
        if isinstance(member, t.Item):
            yield from allowances(member)


def _allowed(attribute: t.Attribute, item: t.Item) -> Iterator[Allowed]:
    reason = next((a.value for a in attribute.arguments if a.name == "reason"), None)
    for argument in attribute.arguments:
        if argument.name is None and isinstance(argument.value, t.Name):
            yield Allowed(argument.value.id, reason if isinstance(reason, str) else None, item.span, attribute.span)


def allowed_codes(item: t.Item) -> tuple[str, ...]:
    """The codes that the item's own `@allow` attributes name."""
    return tuple(a.code for a in allowances(item))
