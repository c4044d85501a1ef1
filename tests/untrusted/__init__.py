"""Inputs that nobody vouches for: samples, mutations of them, and the loaders that they meet."""
