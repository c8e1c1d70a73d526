"""Automata with flows and jumps: all runs enclosed by the kernel, claims decided on the enclosures."""
