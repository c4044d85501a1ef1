"""Dry grains."""
