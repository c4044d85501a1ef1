"""The loop over time and its files; imports nothing, which keeps ``debrisflow check`` fast."""
