"""Debris flows in flumes, and the cases of the study."""
