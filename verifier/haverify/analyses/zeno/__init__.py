"""Runs whose jumps accumulate: a time to go that flows and jumps use up, so that no run has an instant after it."""
