"""Pictures and animations of the particles of a run."""

from debrisflow.results.pictures.render import render

__all__ = ["render"]
