"""Invariants found by exact algebra, linear and semidefinite programs: cuts with the rules that keep them."""
