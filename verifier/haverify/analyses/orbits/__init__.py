"""Periodic orbits that are proved: return maps enclosed with their derivatives, Newton's method in intervals."""
