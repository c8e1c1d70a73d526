"""Conditions on real numbers that have no common point, and identities that show it (`docs/core.md`, section 9)."""
