"""Invariants: what a claim comes down to is proved part by part, or a state is shown that leaves it."""
