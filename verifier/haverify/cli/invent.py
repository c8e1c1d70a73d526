"""`haverify invent`: find an invariant that implies a claim, and print it as `.ha` to paste."""

from __future__ import annotations

import argparse
import sys

from haverify.cli.output import put, wants_colour
from haverify.diagnostics.codes import is_meaningless
from haverify.diagnostics.order import settle
from haverify.diagnostics.render import render_all
from haverify.model.claim import Claim
from haverify.model.spec import Spec
from haverify.report.exit_codes import OK, UNDECIDED, UNREADABLE
from haverify.run.examine import read
from haverify.run.pipeline import require_known


def run(called: argparse.Namespace) -> int:
    """Print what was found for each claim; exit code 3 where nothing was found for one, 2 where the spec is unclear."""
    spec, sources, found = read(called.file)
    errors = settle(d for d in found if is_meaningless(d))
    if spec is None or errors:
        sys.stderr.write(render_all(errors, sources, wants_colour()))
        return UNREADABLE
    if called.property is not None:
        require_known(called.file, called.property, [c.name for c in spec.claims])
    code = OK
    for claim in spec.claims:
        if called.property in (None, claim.name, claim.name.split("[")[0]) and _is_eligible(claim):
            text = _text(spec, claim, called.seconds)
            code = code if text else UNDECIDED
            put(text or f"// nothing found for `{claim.name}`\n")
    return code


def _is_eligible(claim: Claim) -> bool:
    return len(claim.goals) == 1 and claim.goals[0].kind == "always" and not claim.inductive


def _text(spec: Spec, claim: Claim, seconds: float) -> str | None:
    """The declaration of an invariant for a claim; None where none was found."""
    from haverify.analyses.induction.invented import invent
    from haverify.analyses.induction.written import written
    from haverify.obligations.induction import Induction
    from haverify.obligations.translate import OutsideFragmentError

    automaton = next((a for a in spec.automata if a.name == claim.on), None)
    if automaton is None:
        return None
    try:
        induction = Induction(spec, automaton, claim, claim.goals[0])
        induction.check()
        found = invent(induction, seconds)
    except OutsideFragmentError as e:
        return f"// `{claim.name}` is outside of what is searched: {e}\n"
    if found is None:
        return None
    name = "".join(c if c.isalnum() else "_" for c in f"{claim.name}_because")
    told = {m: written(f, automaton) for m, f in found.formulas.items()}
    condition = " and ".join(f"(at({m}) implies {text})" for m, text in told.items() if text != "true")
    if len(automaton.modes) == 1:
        condition = told[automaton.modes[0].name]
    return f"/// Implies `{claim.name}`.\ninvariant {name} on {automaton.name}: {condition} inductive\n"
