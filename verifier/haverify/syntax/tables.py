"""`python -m haverify.syntax.tables` turns grammar.lark into tables.json, the LALR(1) tables `parse` runs on.

Lark is needed here only, so that reading a spec costs neither its import nor the construction of the tables.
"""

from __future__ import annotations

import hashlib
import json
import logging
import re
import sys
from pathlib import Path
from typing import Any

GRAMMAR = Path(__file__).with_name("grammar.lark")
TABLES = Path(__file__).with_name("tables.json")
WORD = r"[A-Za-z_][A-Za-z0-9_]*"


class _Conflicts(logging.Handler):
    """Collects what Lark says about shift/reduce conflicts, which it otherwise settles silently."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.found: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        message = record.getMessage()
        if "conflict" in message.lower():
            self.found.append(message)


def _compiled(grammar: str) -> Any:
    """The grammar as Lark compiled it; raises ValueError when it is not LALR(1)."""
    import lark

    conflicts = _Conflicts()
    level = lark.logger.level
    lark.logger.addHandler(conflicts)
    lark.logger.setLevel(logging.DEBUG)
    try:
        compiled = lark.Lark(grammar, parser="lalr", debug=True, maybe_placeholders=True)
    finally:
        lark.logger.removeHandler(conflicts)
        lark.logger.setLevel(level)
    if conflicts.found:
        raise ValueError("\n".join(conflicts.found))
    return compiled


def _rule_key(rule: Any) -> tuple[str, list[str], str]:
    return rule.origin.name, [symbol.name for symbol in rule.expansion], rule.alias or ""


def _plan(rule: Any) -> list[list[int]]:
    """For each kept child its place in the rule, whether it is a list to splice, and the absent ones before it."""
    expansion, empty = rule.expansion, rule.options.empty_indices
    bits = "".join(str(int(bit)) for bit in empty) if empty else "0" * len(expansion)
    absent = [len(ones) for ones in bits.split("0")]
    plan, waiting = [], 0
    for place, symbol in enumerate(expansion):
        waiting += absent[place]
        if rule.options.keep_all_tokens or not (symbol.is_term and symbol.filter_out):
            splice = not symbol.is_term and symbol.name.startswith("_")
            plan.append([place, int(splice), waiting])
            waiting = 0
    return [*plan, [-1, 0, waiting + absent[len(expansion)]]]


def _rule_row(rule: Any) -> list[Any]:
    """Origin, callback, number of symbols, plan, and whether a single child stands for the whole."""
    single = bool(rule.options.expand1 and not rule.alias)
    return [rule.origin.name, rule.alias or rule.origin.name, len(rule.expansion), _plan(rule), single]


def _ordered_states(states: dict[int, Any], start: int) -> list[int]:
    """All states in the order in which they are met from the start, independent of hash order."""
    order, seen = [start], {start}
    for state in order:
        for _, (action, argument) in sorted(states[state].items(), key=lambda entry: str(entry[0])):
            if str(action) == "Shift" and argument not in seen:
                seen.add(argument)
                order.append(argument)
    return order


def _state_rows(table: Any, rules: list[Any]) -> list[dict[str, int]]:
    """Per state: symbol to next state, or to -1 - rule for a reduction; the last one accepts."""
    start = table.start_states["start"]
    order = _ordered_states(table.states, start)
    number = {state: place for place, state in enumerate(order)}
    of_rule = {id(rule): place for place, rule in enumerate(rules)}
    rows = []
    for state in order:
        actions = sorted((str(symbol), entry) for symbol, entry in table.states[state].items())
        rows.append({s: number[arg] if str(act) == "Shift" else -1 - of_rule[id(arg)] for s, (act, arg) in actions})
    end = number[table.end_states["start"]]
    rows[end]["$END"] = len(rows)
    return [*rows, {}]


def _spellings(terminals: list[Any]) -> tuple[dict[str, str], dict[str, str]]:
    """Words and symbols of the grammar, each with the terminal it belongs to."""
    words: dict[str, str] = {}
    symbols: dict[str, str] = {}
    for terminal in sorted(terminals, key=lambda t: str(t.name)):
        value = terminal.pattern.value
        choice = re.fullmatch(r"\(\??:?([a-z|]+)\)(?:\\b)?", value)
        if choice:
            words |= dict.fromkeys(choice[1].split("|"), terminal.name)
        elif terminal.name == "CMP":
            symbols |= dict.fromkeys(("<=", ">=", "==", "!=", "<", ">"), "CMP")
        elif terminal.pattern.type == "str":
            (words if re.fullmatch(WORD, value) else symbols)[value] = terminal.name
    return words, symbols


def _scanner(patterns: dict[str, str], symbols: dict[str, str]) -> str:
    """One expression that matches the next piece of any text: blanks, then exactly one named group."""
    operators = "|".join(re.escape(s) for s in sorted(symbols, key=lambda s: (-len(s), s)))
    quantity, number = patterns["QUANTITY"], patterns["NUMBER"]
    groups = [
        ("WORD", WORD),
        ("GAP", r"[;\n][; \t\r\n]*"),
        ("COMMENT", patterns["COMMENT"]),
        ("DOC", patterns["DOC"]),
        ("BITS", patterns["BITS"] + "(?![0-9A-Za-z_])"),
        ("QUANTITY", quantity),
        ("NUMBER", number),
        ("STRING", patterns["STRING"]),
        ("OPERATOR", operators),
        ("END", r"\Z"),
        ("BAD", r'"[^\n]*|[^\x00-\x7f]\w*|.'),
    ]
    return r"[ \t\r]*(?:" + "|".join(f"(?P<{name}>{pattern})" for name, pattern in groups) + ")"


def generate() -> dict[str, Any]:
    """The tables of grammar.lark; the same on every run."""
    grammar = GRAMMAR.read_text(encoding="utf-8")
    compiled = _compiled(grammar)
    table = compiled.parser.parser._parse_table
    rules = sorted(compiled.rules, key=_rule_key)
    by_key = {str(_rule_key(rule)): rule for rule in rules}
    _share_rules(table, by_key)
    rows = _state_rows(table, rules)
    patterns = {t.name: t.pattern.value for t in compiled.terminals if t.pattern.type == "re"}
    words, symbols = _spellings(compiled.terminals)
    reserved = sorted(word for word in words if not re.fullmatch(patterns["NAME"], word))
    items = [row for row in rows if "_ERROR" in row]
    return {
        "sha256": hashlib.sha256(grammar.encode()).hexdigest(),
        "words": words,
        "symbols": symbols,
        "reserved": reserved,
        "starters": [word for word in reserved if any(words[word] in row for row in items)],
        "scanner": _scanner(patterns, symbols),
        "unit": patterns["UNIT"],
        "number": patterns["NUMBER"],
        "rules": [_rule_row(rule) for rule in rules],
        "states": rows,
    }


def _share_rules(table: Any, by_key: dict[str, Any]) -> None:
    """Make every reduction of the table name one of the rules of `by_key`."""
    for row in table.states.values():
        for symbol, (action, argument) in row.items():
            if str(action) != "Shift":
                row[symbol] = (action, by_key[str(_rule_key(argument))])


def main() -> int:
    """Write tables.json."""
    TABLES.write_text(json.dumps(generate(), separators=(",", ":"), sort_keys=True) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
