"""The arrays in the particle files of a run, in one table.

The writer of the files, their reader, the coloring of pictures, the choices of the command line
and the documentation all come from this table.  It imports nothing, so that help stays instant.
"""

from __future__ import annotations

from typing import NamedTuple


class OutputArray(NamedTuple):
    """One array of the particle files, copied from the array of the same name in the particles.

    Attributes
    ----------
    name : str
        In the files and in :class:`debrisflow.particles.record.Particles`.
    unit : str
        Empty for a number without one.
    meaning : str
        In words, without the unit.
    storage : str
        Name of the NumPy type in the file.
    label : str
        Words beside the scale of colors, without the unit; empty if no picture is colored by it.
    components : int
        1, or 3 for a vector.
    magnitude : str
        Name of the length of a vector, by which it is colored.
    optional : bool
        Whether it is there only in runs whose particles have it.
    """

    name: str
    unit: str
    meaning: str
    storage: str
    label: str = ""
    components: int = 1
    magnitude: str = ""
    optional: bool = False

    @property
    def color_key(self) -> str:
        """The word that asks for a picture colored by this array."""
        return self.magnitude or self.name

    @property
    def color_label(self) -> str:
        """The words beside the scale of colors, with the unit."""
        unit = self.unit.translate(str.maketrans("23", "²³"))
        return f"{self.label} ({unit})" if unit else self.label


# Most reals are stored in single precision, which is finer than the tolerance of the solvers.  The
# sediment fraction is not, because its sum is the volume of the sediment.
ARRAYS = (
    OutputArray("velocity", "m/s", "velocity", "float32", "speed", components=3, magnitude="speed"),
    OutputArray("pressure", "Pa", "pressure", "float32", "pressure"),
    OutputArray("density", "kg/m3", "material density of the particle", "float32"),
    OutputArray("number_density", "", "particle number density n", "float32"),
    OutputArray(
        "concentration",
        "",
        "volumetric sediment concentration around the particle",
        "float32",
        "sediment concentration",
    ),
    OutputArray(
        "granular_temperature",
        "m2/s2",
        "granular temperature",
        "float32",
        "granular temperature",
    ),
    OutputArray(
        "sediment_fraction",
        "",
        "volume of sediment in the particle: 0 liquid, 1 sediment, between for a mixture",
        "float64",
    ),
    OutputArray(
        "kind",
        "",
        "0 liquid, 1 sediment, 2 mixture, 3 wall, 4 dummy wall, 5 inflow",
        "int8",
        "kind",
    ),
    OutputArray(
        "pore_pressure",
        "",
        "share of the load on the particle that pore water bears, if a fill or release has one",
        "float32",
        optional=True,
    ),
    OutputArray("on_free_surface", "", "1 on the free surface, else 0", "uint8"),
    OutputArray(
        "id",
        "",
        "number that the particle keeps for the whole run",
        "int64",
    ),
)

COLORED = {array.color_key: array for array in ARRAYS if array.label}
