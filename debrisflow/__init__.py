"""Particle simulation (MPS) of debris flows from TOML case files."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("debrisflow")
except PackageNotFoundError:  # a source tree that was never installed
    __version__ = "0+unknown"
