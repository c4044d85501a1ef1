"""Calibration: parameters by observations, what remains unknown of them, and what follows."""
