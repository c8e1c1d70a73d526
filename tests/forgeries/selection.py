"""Few damages of a large report that stand for all: fewer claims, and each sort of damage once."""

import json
import re
from collections.abc import Sequence
from pathlib import Path

from tests.forgeries.damage import Forge, damages


def thin(folder: Path) -> None:
    """Leave in a true report the first claim of each shape; the others become unknown, which needs no certificate."""
    report = json.loads((folder / "report.json").read_text())
    seen: set[str] = set()
    for claim in report["claims"]:
        path = _certificate(folder, claim["name"])
        if not path.is_file():
            continue
        shape = _shape(json.loads(path.read_text()))
        if shape in seen:
            path.unlink()
            claim |= {"verdict": "unknown", "trust": None, "rounding": None, "parts": []}
        seen.add(shape)
    (folder / "report.json").write_text(json.dumps(report))


def chosen(folder: Path, number: int) -> list[tuple[str, Forge]]:
    """Damages of a folder: each sort once, taking turns among the certificates, then others, evenly spread."""
    sorts: dict[str, list[tuple[str, Forge]]] = {}
    for name, forge in damages(folder):
        sorts.setdefault(sort_of(name), []).append((name, forge))
    found = [_turn(members, k) for k, members in enumerate(sorts.values())]
    taken = {name for name, _ in found}
    others = [d for members in sorts.values() for d in members if d[0] not in taken]
    return found + others[:: max(1, len(others) // max(1, number - len(found)))][: max(0, number - len(found))]


def sort_of(name: str) -> str:
    """What a damage does, whatever it does it to."""
    if name.startswith("swapped ") or " with the goals of " in name:
        return "swapped" if name.startswith("swapped ") else "with the goals of another"
    where = name.split(" ")[0] if name.split(" ")[0] in ("report", "core", "cells") else "certificate"
    return f"{where}: {re.sub(r'[0-9]+', '#', name.rpartition(': ')[2])}"


def _turn(members: Sequence[tuple[str, Forge]], k: int) -> tuple[str, Forge]:
    """The first damage to the k-th of the claims that this sort concerns."""
    first: dict[str, tuple[str, Forge]] = {}
    for name, forge in members:
        first.setdefault(re.split(r" goal | rounded |: ", name)[0], (name, forge))
    return list(first.values())[k % len(first)]


def _certificate(folder: Path, claim: str) -> Path:
    return folder / "certificates" / (claim.replace("[", "(").replace("]", ")") + ".json")


def _shape(certificate: dict) -> str:
    """What a certificate is made of, numbers and names apart."""
    rounding = certificate["rounding"]
    goals = [
        sorted({(g["kind"], p.get("kind", ""), "run" in p, "proof" in p) for p in g.get("parts", [{}])})
        for g in certificate["goals"]
        if g
    ]
    return repr((certificate["verdict"], sorted({repr(g) for g in goals}), rounding and rounding["verdict"]))
