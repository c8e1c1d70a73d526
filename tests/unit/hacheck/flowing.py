"""Specs about flows, decided, with the certificates that hacheck gets."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from hacheck.core import Core
from hacheck.obligations import Setting, established
from haverify.analyses.hybrid.decide import decide_flow
from haverify.model.core import canonical, to_core
from haverify.run.examine import read

Json = Any


class Flowing:
    """One claim on one automaton with flows: its core, certificate and record, to be damaged and checked."""

    def __init__(self, folder: Path, text: str) -> None:
        path = folder / "flow.ha"
        path.write_text(f'spec "S" version "1.0" unitless\n{text}\n', encoding="utf-8")
        spec = read(str(path))[0]
        assert spec is not None
        core = to_core(spec)
        found = decide_flow(spec, spec.automata[0], spec.claims[0], core)
        self.core: Json = json.loads(canonical(core))
        assert found.certificate is not None, found.verdict
        self.certificate: Json = json.loads(canonical(found.certificate))
        self.cells: dict[str, Json] = {name: json.loads(canonical(c)) for name, c in found.cells.items()}

    @property
    def record(self) -> Json:
        """The recorded flow of the only goal."""
        (found,) = self.cells.values()
        return found

    @property
    def steps(self) -> list[Json]:
        """The steps of the only piece."""
        found: list[Json] = self.record["starts"][0]["pieces"]["steps"]
        return found

    def after(self, count: int) -> Json:
        """The stretch after some jumps, or the jump before it."""
        node = self.record["starts"][0]["pieces"]
        for _ in range(count):
            node = node["jumps"][0]
        return node

    @property
    def entry(self) -> Json:
        """The certificate's entry for the only goal."""
        return self.certificate["goals"][0]

    def shown(self) -> str:
        """The verdict that hacheck finds established; Refused where it finds none."""
        core = Core(self.core)
        setting = Setting(core, next(iter(core.automata.values())), False, self.cells.__getitem__)
        claim = next(iter(core.claims.values()))
        return established(core, claim, self.certificate, lambda _, rounding: setting)[0]
