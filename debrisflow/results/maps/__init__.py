"""Maps of the layers of a run: sheets as pictures, and a page that works without a network."""

from debrisflow.results.maps.pictures import draw_maps

__all__ = ["draw_maps"]
