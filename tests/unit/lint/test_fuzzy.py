"""HA510 to HA514: what is wrong with fuzzy systems, exactly."""

FORCE = (
    "input force: N over [0 N, {high} N] {{ small = trap(0 N, 0 N, 4 N, 5 N); large = trap({low} N, 5 N, 12 N, 12 N) }}"
)
RULES = "rule force is small => action is wait\n rule force is large => action is step"


def system(inputs: str, rules: str = RULES, terms: str = "wait, step") -> str:
    return f"fuzzy F {{\n {inputs}\n output action {{ {terms} }}\n logic min max\n {rules}\n}}\n"


def force(low: str = "4", high: str = "12") -> str:
    return FORCE.format(low=low, high=high)


TWICE = """rule A: roll is yes => action is step
 rule B: roll is yes => action is step
 rule roll is no => action is wait"""
DIRECTIONS = """input roll: 1 over [0, 1] { no = ramp(1, 0); yes = ramp(0, 1) }
 input pitch: 1 over [0, 1] { no = ramp(1, 0); yes = ramp(0, 1) }"""


def test_a_system_without_faults_has_no_finding(lint):
    assert lint(system(force())).found == []


def test_HA510_names_the_values_without_a_term(lint):
    (d,) = lint(system(force(high="15"))).of("HA510")
    assert d.message == "force in (12 N, 15 N]: no term above 0"


def test_HA510_between_terms_that_only_touch(lint):
    (d,) = lint(system(force(low="5").replace("trap(5 N, 5 N", "trap(5 N, 6 N"))).of("HA510")
    assert d.message == "force = 5 N: no term above 0"


def test_HA510_is_silent_at_the_end_where_a_ramp_begins(lint):
    one = "input roll: 1 over [0, 1] { yes = ramp(0, 1) }"
    assert lint(system(one, "rule roll is yes => action is step\n rule not roll is yes => action is wait")).found == []


def test_HA511_shows_the_combination_that_the_rules_forget(lint):
    rules = "rule roll is yes and pitch is yes => action is step\n rule roll is no and pitch is no => action is wait"
    (d,) = lint(system(DIRECTIONS, rules)).of("HA511")
    assert d.message == "pitch = 0, roll = 1: all 2 rules for action are 0"


def test_HA512_premises_are_equal_up_to_order(lint):
    rules = (
        "rule A: roll is yes and pitch is no => action is step\n rule B: pitch is no and roll is yes => action is wait"
    )
    (d,) = lint(system(DIRECTIONS, rules)).of("HA512")
    assert d.message == "A and B have the same premise; `step` and `wait` are always equally strong"


def test_HA512_is_silent_about_equal_conclusions(lint):
    rules = TWICE
    assert lint(system(DIRECTIONS, rules)).of("HA512") == []


def test_HA513_of_two_equal_rules_the_later_is_idle(lint):
    rules = TWICE
    (d,) = lint(system(DIRECTIONS, rules)).of("HA513")
    assert d.message == "B never exceeds A for any input; it has no effect"


def test_HA513_terms_that_never_meet(lint):
    rules = RULES + "\n rule C: force is small and force is large => action is wait"
    separate = system(force(low="5").replace("trap(5 N, 5 N", "trap(5 N, 6 N"), rules)
    (d,) = lint(separate).of("HA513")
    assert d.message == "C of F never fires"


def test_HA513_a_rule_that_several_others_cover(lint):
    rules = """rule A: roll is yes and pitch is yes => action is step
 rule B: roll is yes and pitch is no => action is step
 rule C: roll is yes and (pitch is yes or pitch is no) => action is step
 rule roll is no => action is wait"""
    (d,) = lint(system(DIRECTIONS, rules)).of("HA513")
    assert d.message == "C never exceeds the other rules for `step` for any input; it has no effect"


def test_HA514_terms_that_no_rule_concludes(lint):
    (d,) = lint(system(force(), terms="wait, step, fall")).of("HA514")
    assert d.message == "the rules of F never conclude `fall` of action"
