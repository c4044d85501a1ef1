"""The loop over time and what it writes; imports nothing, so that a case is checked at once."""
