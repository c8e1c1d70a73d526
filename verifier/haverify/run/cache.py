"""Proposed evidence kept between runs: JSON files in a folder of the user, never believed.

A claim's key covers what its verdict depends on: model, claim, options, versions. What is read back is evidence again:
`hacheck` decides about it like about any other, and what it refuses is computed anew. A damaged or edited file fails
its digest or its reading and costs the time to decide again, nothing else. Only conclusive evidence is kept.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from typing import Any

from haverify.evidence.as_json import evidence_from, evidence_to
from haverify.evidence.evidence import Evidence
from haverify.evidence.verdict import Unknown
from haverify.run import kept

_SCHEMA = "haverify.cache/1"


def fetch(model: str, claims: Mapping[str, str]) -> dict[str, Evidence]:
    """The kept evidence of the claims (name to key) about the model with key `model`."""
    pack = _pack(model)
    found = {}
    for name, key in claims.items():
        entry = pack["claims"].get(key)
        if entry is not None and (evidence := _evidence(entry, pack["cells"])) is not None:
            found[name] = evidence
    return found


def keep(model: str, claims: Mapping[str, str], evidence: Mapping[str, Evidence]) -> None:
    """Add conclusive evidence to what is kept about a model; another process may do the same, the last one wins."""
    pack = _pack(model)
    for name, e in evidence.items():
        if isinstance(e.verdict, Unknown) or e.certificate is None:
            continue
        names = {cell: _digest(content) for cell, content in e.cells.items()}
        pack["cells"].update({names[cell]: content for cell, content in e.cells.items()})
        pack["claims"][claims[name]] = {"evidence": evidence_to(e), "cells": names}
    kept.store(model, {"schema": _SCHEMA, **pack})


def _evidence(entry: Any, cells: Mapping[str, Any]) -> Evidence | None:
    try:
        own = {name: cells[digest] for name, digest in entry["cells"].items()}
        return evidence_from(entry["evidence"], own)
    except (ValueError, KeyError, TypeError, AttributeError):
        return None


def _digest(content: Any) -> str:
    return hashlib.sha256(kept.canonical(content)).hexdigest()


def _pack(model: str) -> dict[str, dict[str, Any]]:
    """What is kept about a model: `claims` by key, `cells` by digest; empty where nothing of this version is."""
    pack = kept.load(model)
    if not isinstance(pack, dict) or pack.get("schema") != _SCHEMA:
        return {"claims": {}, "cells": {}}
    if not isinstance(pack.get("claims"), dict) or not isinstance(pack.get("cells"), dict):
        return {"claims": {}, "cells": {}}
    return {"claims": pack["claims"], "cells": pack["cells"]}
