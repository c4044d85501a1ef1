"""Viscous and turbulent flows, and slurries that yield."""
