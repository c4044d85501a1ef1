"""Watchdogs: they find faults of a run early and say what, where, why and what to do."""
