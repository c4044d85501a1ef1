"""Self-contained pages: one HTML file that carries its style and pictures and loads nothing."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Any, NamedTuple

import jinja2
from markupsafe import Markup

from debrisflow.results.station_figures import figure
from debrisflow.run.atomic import replaced

OWN = "debrisflow.results"
"""The package whose templates all pages share."""
WHOLE_FROM = 1000.0  # figures without decimals
LARGEST_PICTURE = 8 * 2**20  # bytes, of one that a page still carries
SHARED_STYLE = "page.css"


class Picture(NamedTuple):
    """An image of the page, in its text.

    Attributes
    ----------
    name, text : str
        Of the file, and what it shows.
    source : str
        A data URL.
    """

    name: str
    text: str
    source: str


def write_html(
    path: Path,
    template: str,
    contents: Mapping[str, Any],
    package: str = OWN,
    style: str = "",
    script: str = "",
) -> None:
    """Write a page by a template.

    Parameters
    ----------
    path : Path
    template : str
    contents : mapping
        What the template names.
    package : str
        In whose folder ``templates`` the template is looked for, before that of all pages.
    style, script : str
        Files of that folder that only this kind of page has.

    Raises
    ------
    OutputError
        If the file cannot be written.
    """
    places = dict.fromkeys((package, OWN))
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(one, "templates") for one in places]),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["figure"] = figure
    environment.filters["rounded"] = rounded
    looks = as_it_stands(SHARED_STYLE) + (as_it_stands(style, package) if style else Markup())
    program = as_it_stands(script, package) if script else Markup()
    parts = {"style": looks, "script": program, "policy": policy(looks, program)}
    page = environment.get_template(template).render(**parts, **contents)
    with replaced(path) as unfinished:
        unfinished.write_text(page, encoding="utf-8")


def rounded(value: float) -> str:
    """Return a figure of four digits, large ones whole and in groups of three digits.

    Examples
    --------
    >>> rounded(12000.4), rounded(0.31124)
    ('12,000', '0.3112')
    """
    return f"{value:,.0f}" if abs(value) >= WHOLE_FROM else figure(value)


def as_it_stands(name: str, package: str = OWN) -> Markup:
    """Return the text of a file of the templates."""
    return Markup(files(package).joinpath("templates", name).read_text("utf-8"))


def policy(style: str, script: str) -> str:
    """Return what a browser lets a page do: no network, and no style or script but these.

    Whatever stands in a title or a name is text; if it ever came to be more, it would not run.

    Examples
    --------
    >>> policy("", "").partition("; style")[0]
    "default-src 'none'; base-uri 'none'; form-action 'none'; img-src data:"
    """
    known = {
        kind: "'sha256-" + b64encode(sha256(text.encode()).digest()).decode() + "'"
        for kind, text in (("style", style), ("script", script))
        if text
    }
    rules = ["default-src 'none'", "base-uri 'none'", "form-action 'none'", "img-src data:"]
    return "; ".join([*rules, *(f"{kind}-src {digest}" for kind, digest in known.items())])


def is_picture(file: Path) -> bool:
    """Return whether a file is a picture that a page can carry, by its first bytes and its size."""
    if not file.is_file() or file.stat().st_size > LARGEST_PICTURE:
        return False
    with file.open("rb") as stream:
        return stream.read(6).startswith((b"\x89PNG", b"GIF8"))


def picture_of(file: Path, name: str, text: str) -> Picture:
    """Return a picture with its name and what it shows."""
    data = b64encode(file.read_bytes()).decode("ascii")
    return Picture(name, text, f"data:image/{file.suffix[1:]};base64,{data}")
