"""Runs in floating point: they show what a model does, and where to look; they prove nothing."""
