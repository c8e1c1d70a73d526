"""Claims are those of the file that is checked, whatever it imports and however."""

import pytest

from haverify.elaborate.elaborate import elaborate
from haverify.run.load import load

MACHINE = (
    'spec "m" version "1.0"\nautomaton A {\n  var x: s\n  init M with x := 0 s\n  mode M { flow { x\' = 1 } }\n}\n'
)


@pytest.mark.parametrize("clause, name", [('import "m.ha"', "A"), ('import "m.ha" as m', "m.A")])
def test_claims_of_the_importing_file_are_kept_and_those_of_the_imported_left_out(tmp_path, clause, name):
    (tmp_path / "m.ha").write_text(MACHINE + "property theirs on A { always x >= 0 s }\n")
    (tmp_path / "a.ha").write_text(f'spec "a" version "1.0"\n{clause}\nproperty ours on {name} {{ always x >= 0 s }}\n')
    loaded, problems = load(tmp_path / "a.ha")
    assert loaded is not None and not problems
    spec, found = elaborate(loaded.tree, loaded.files)
    assert [c.name for c in spec.claims] == ["ours"]
    assert not [d for d in found if d.code.startswith("HA0")]
