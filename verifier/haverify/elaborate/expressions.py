"""Syntax to typed exact expressions: names resolved, units checked, quantifiers over enumerations written out."""

from __future__ import annotations

from haverify.elaborate import operators as operators
from haverify.elaborate.conditions import later, seconds
from haverify.elaborate.intervals import interval, range_in
from haverify.elaborate.names import cells_of, denote, family_enum, index_value, source_name, value_of
from haverify.elaborate.reading import Env, Found, boolean, exact, of_type, real, type_phrase, typed

__all__ = [
    "Env",
    "Found",
    "boolean",
    "cells_of",
    "denote",
    "exact",
    "family_enum",
    "index_value",
    "interval",
    "later",
    "of_type",
    "operators",
    "range_in",
    "real",
    "seconds",
    "source_name",
    "type_phrase",
    "typed",
    "value_of",
]
