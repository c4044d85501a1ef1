"""Grains that settle, and beds of them."""
