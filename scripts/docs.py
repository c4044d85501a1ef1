"""Write the generated parts of the documentation, or check that they are up to date.

python scripts/docs.py [--check]

Generated are the tables of ``docs/case_file.md``, from the schema of a case, and of
``docs/many_runs.md``, from that of a study, which stands in ``cases/study.schema.json`` too; those
of ``docs/run_folder.md`` and ``docs/long_runs.md``; and the pages in ``docs/cases``, from the
shipped case files: the comment at the head of each, its values and its picture.  The page
``docs/validation.md`` and the table of the README are made of what ``debrisflow validate -o
docs/validation`` has left.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import click
from docs_headlines import headlines

from debrisflow.case import case_schema
from debrisflow.particles.arrays import ARRAYS
from debrisflow.run.events import FIELDS
from debrisflow.run.folder_status import MORE_FIELDS, SEEN
from debrisflow.study.loading import study_schema
from debrisflow.validation.figures import FIGURES, drawn
from debrisflow.validation.page import page as validation_page
from debrisflow.validation.publication import results_in

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
CASES = ROOT / "cases"
README = ROOT / "README.md"
VALIDATION = DOCS / "validation"
BEGIN, END = "<!-- generated:begin -->\n", "<!-- generated:end -->\n"
NOT_BY_HAND = "<!-- written by scripts/docs.py from cases/{}.toml; do not edit -->"
# what the comment at the head of a case says, by the words with which it begins
TOPICS = {
    "Source": "Source",
    "Not in the study, chosen here": "Chosen, since the study does not state it",
    "Chosen": "Chosen",
    "Calibrated": "Calibrated",
    "Expect": "What to expect",
    "Takes": "Time it takes",
}
PICTURES = {  # of the pages of cases, where a comparison has one
    "heap3d": "lube_heap",
    "marin3d": "spheric2",
    "poiseuille2d": "poiseuille",
    "usgs_flume3d": "usgs_flume",
}
NOT_PARAMETERS = ("title", "time", "output", "probe")
CHOOSING = ("type", "distribution")  # fields that choose among tables
SCALARS = {
    "number": "number",
    "integer": "integer",
    "string": "text",
    "boolean": "true or false",
    "object": "table",
}
ENTRIES = {"array": "points", "string": "texts"}
CAPTIONS = {
    "bed_erosion2d": "Water (blue) erodes a bed of sediment (red) and water.",
    "channelled_fan": "Peak depth of the flow from the torrent, past the check dam, onto the fan.",
    "check_dam3d": "The flow meets the dam and passes over its crest; colors show the speed.",
    "column_collapse2d": "Without (left) and with collision stress (right).",
    "dam_break2d": "The column collapses, and its front climbs the far wall.",
    "dam_break3d": "The cube spreads from its corner; colors show the speed.",
    "flume2d": "Water (blue) erodes a bed of sediment (red) and water; heights are stretched.",
    "flume3d": "The water reaches the bed and moves its surface; colors show the speed.",
    "flume_deposit2d": "The flow deposits its sediment (red) behind the bend.",
    "heap3d": "Outlines of heaps at rest, and the front by the law of Lube et al.",
    "hydrostatic2d": "The water stays at rest; colors show the pressure.",
    "hydrostatic_two_phase2d": "The heavy layer (red) stays below the water; colors show the kind.",
    "marin3d": "Levels in the tank, and pressures on the face of the box, measured and computed.",
    "mt_st_helens2021": "Cells that the flow reaches by more than 0.3 m, and those in which the "
    "ground has changed by more than that.",
    "poiseuille2d": "The flow starts from rest: profiles of the speed, computed and by the series.",
    "runout3d": "Plan of three flows at 4 s: with collision stress, and without it with "
    "viscosities of 1e-3 and 1e-6 m²/s.",
    "settling2d": "The grains (red) leave clear water above and pack at the floor.",
    "still_tank3d": "The water stays at rest; colors show the pressure.",
    "usgs_flume3d": "Depths at the three sections, measured and computed.",
}


class Field(NamedTuple):
    """A row of the tables of the case file."""

    name: str
    type: str
    unit: str
    default: str
    limits: str
    meaning: str


def pages() -> dict[Path, str]:
    """Return the text of every page that is generated or has a generated part, by its path."""
    schema = json.loads(case_schema())
    study = json.loads(study_schema())
    written = {
        DOCS / "case_file.md": renewed("case_file.md", sections(schema)),
        DOCS / "many_runs.md": renewed("many_runs.md", sections(study)),
        CASES / "study.schema.json": study_schema(),
        DOCS / "run_folder.md": renewed("run_folder.md", arrays()),
        DOCS / "long_runs.md": renewed("long_runs.md", status_fields()),
    }
    results = results_in(VALIDATION)
    written[DOCS / "validation.md"] = validation_page(
        results,
        drawn(VALIDATION),
        f"{VALIDATION.name}/{FIGURES}",
        "What misses its limit is discussed at length, with what was tried, on the page "
        "[Misses](misses.md).",
    )
    accuracy = "\n".join(headlines(results)) + "\n"
    written[README] = with_part(README.read_text(encoding="utf-8"), accuracy)
    cases = {path.stem: path for path in sorted(CASES.glob("*.toml"))}
    for name, path in cases.items():
        written[DOCS / "cases" / f"{name}.md"] = page_of_case(
            name, path.read_text(encoding="utf-8"), schema
        )
    written[DOCS / "cases" / "index.md"] = index_of_cases(cases)
    return written


def renewed(name: str, lines: Iterator[str]) -> str:
    """Return a page with its generated part renewed."""
    text = (DOCS / name).read_text(encoding="utf-8")
    return with_part(text, "\n" + "\n".join(lines) + "\n")


def with_part(text: str, part: str) -> str:
    """Return a page with another generated part."""
    before, rest = text.split(BEGIN)
    return before + BEGIN + part + END + rest.split(END)[1]


def arrays() -> Iterator[str]:
    """Yield the table of the arrays in the particle files."""
    yield "| array | unit | meaning |"
    yield "|---|---|---|"
    for array in ARRAYS:
        yield f"| `{array.name}` | {array.unit} | {array.meaning} |"


def status_fields() -> Iterator[str]:
    """Yield the tables of the fields of ``status.json``, and of ``debrisflow status``."""
    yield "| field | unit | meaning |"
    yield "|---|---|---|"
    for field in FIELDS:
        yield f"| `{field.name}` | {field.unit} | {field.meaning} |"
    seen = "; ".join(f"`{state}`: {meaning}" for state, meaning in SEEN.items())
    yield f"\n`debrisflow status --json` adds these; its `state` may also be one of: {seen}.\n"
    yield "| field | unit | meaning |"
    yield "|---|---|---|"
    for field in MORE_FIELDS:
        yield f"| `{field.name}` | {field.unit} | {field.meaning} |"


def sections(schema: dict[str, Any]) -> Iterator[str]:
    """Yield the lines of a section for each entry of a case file, in its order."""
    tables = {name: prop for name, prop in schema["properties"].items() if branches(prop, schema)}
    plain = {name: prop for name, prop in schema["properties"].items() if name not in tables}
    yield "## Top level\n"
    yield from table(plain, schema, schema["required"])
    for name, prop in tables.items():
        yield f"\n## {name}\n"
        is_required = name in schema["required"]
        if is_list(prop):
            opening = f"`[[{name}]]`, {'once or more' if is_required else 'any number of times'}"
        else:
            opening = f"`[{name}]`, {'required' if is_required else 'optional'}"
        yield f"{opening}. {sentence(prop.get('description', ''))}".rstrip()
        for part in branches(prop, schema):
            yield from section(name, part, schema)


def section(name: str, part: dict[str, Any], schema: dict[str, Any]) -> Iterator[str]:
    """Yield the lines on one kind of a table: what it is, its fields, the tables in it."""
    for key in CHOOSING:
        if kind := part["properties"].get(key, {}).get("const"):
            yield f'\n### {name}, {key} = "{kind}"'
    description = part.get("description", "").split("\n\nReferences")[0]
    yield "\n" + sentence(" ".join(description.split())) + "\n"
    rows = {key: prop for key, prop in part["properties"].items() if not only_tables(prop)}
    if rows:
        yield from table(rows, schema, part.get("required", []))
    inner: dict[str, list[str]] = {}
    for key, prop in part["properties"].items():
        for branch in branches(prop, schema):
            inner.setdefault(branch["title"], []).append(key)
    for title, keys in inner.items():
        branch = schema["$defs"][title]
        names = ", ".join(f"`[{name}.{key}]`" for key in keys)
        yield f"\n{names}: {sentence(' '.join(branch['description'].split()))}\n"
        if len(keys) > 1:
            for key in keys:
                yield f"- `{key}`: {part['properties'][key].get('description', '')}"
            yield ""
        yield from table(branch["properties"], schema, branch.get("required", []))
        place = name if len(keys) > 1 else f"{name}.{keys[0]}"
        for key, prop in branch["properties"].items():
            for kind in branches(prop, schema):
                yield from choice(f"{place}.NAME.{key}" if len(keys) > 1 else place, kind, schema)


def choice(place: str, kind: dict[str, Any], schema: dict[str, Any]) -> Iterator[str]:
    """Yield the lines on one of the tables among which a field within a table chooses."""
    description = " ".join(kind.get("description", "").split())
    yield f"\n`[{place}]`: {sentence(description)}\n"
    yield from table(kind["properties"], schema, kind.get("required", []))


def table(
    properties: dict[str, Any], schema: dict[str, Any], required: Sequence[str]
) -> Iterator[str]:
    """Yield the lines of a table of fields."""
    yield "| field | type | unit | default | limits | meaning |"
    yield "|---|---|---|---|---|---|"
    for name, prop in properties.items():
        row = field(name, prop, name in required, schema)
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"


def field(name: str, prop: dict[str, Any], is_required: bool, schema: dict[str, Any]) -> Field:
    """Return the row of a field."""
    if "default" in prop and prop["default"] is not None:
        default = f"`{json.dumps(prop['default'])}`"
    else:
        default = "required" if is_required else "optional"
    unit = prop.get("unit", "-")
    meaning = prop.get("description", "").removesuffix(f" [{unit}]")
    if "const" in prop:
        meaning = "chooses this table"
    return Field(
        f"`{name}`",
        type_of(prop, schema),
        "" if unit == "-" else unit,
        default,
        limits(prop),
        meaning,
    )


def type_of(prop: dict[str, Any], schema: dict[str, Any]) -> str:
    """Return what a value may be, in words."""
    if "const" in prop:
        return f'`"{prop["const"]}"`'
    if "enum" in prop:
        return ", ".join(f'`"{value}"`' for value in prop["enum"])
    options = prop.get("anyOf") or prop.get("oneOf")
    if options:
        return " or ".join(dict.fromkeys(type_of(option, schema) for option in options))
    if "$ref" in prop:
        return "table"
    if prop.get("type") == "array":
        least, most = prop.get("minItems", 0), prop.get("maxItems")
        entry = (prop.get("prefixItems") or [prop.get("items", {})])[0]
        what = ENTRIES.get(entry.get("type", ""), "numbers")
        if most is None:
            return f"list of {what}"
        return f"{most} {what}" if least == most else f"{least} or {most} {what}"
    return SCALARS[prop["type"]]


def limits(prop: dict[str, Any]) -> str:
    """Return the limits of a number."""
    signs = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤"}
    return ", ".join(f"{sign}&nbsp;{prop[key]:g}" for key, sign in signs.items() if key in prop)


def branches(prop: dict[str, Any], schema: dict[str, Any]) -> list[dict[str, Any]]:
    """Return the tables that an entry may be, or be a list of; none if it is a value."""
    options = prop.get("oneOf") or prop.get("anyOf")
    if options:
        return [found for option in options for found in branches(option, schema)]
    if "$ref" in prop:
        found: dict[str, Any] = schema["$defs"][prop["$ref"].rpartition("/")[2]]
        return [found]
    return branches(prop["items"], schema) if isinstance(prop.get("items"), dict) else []


def is_list(prop: dict[str, Any]) -> bool:
    """Return whether an entry is a list of tables."""
    return prop.get("type") == "array"


def only_tables(prop: dict[str, Any]) -> bool:
    """Return whether an entry is a table and cannot be a value."""
    return "$ref" in prop


def sentence(text: str) -> str:
    """Return a text that begins with a capital and ends with a period, or nothing."""
    text = text.strip()
    if not text:
        return ""
    return text[0].upper() + text[1:] + ("" if text.endswith((".", ":")) else ".")


def head_of(text: str) -> tuple[str, dict[str, str]]:
    """Return the first sentences of the comment at the head of a case, and the rest by topic."""
    lines = []
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        if not line.startswith("#:schema"):
            lines.append(line.removeprefix("#").strip())
    words = "|".join(sorted(TOPICS, key=len, reverse=True))
    parts = re.split(rf"(?:^|(?<=[.)]) )({words}): ", " ".join(" ".join(lines).split()))
    return parts[0].strip(), dict(zip(parts[1::2], map(str.strip, parts[2::2]), strict=True))


def page_of_case(name: str, text: str, schema: dict[str, Any]) -> str:
    """Return the page of a shipped case."""
    about, topics = head_of(text)
    picture = picture_of(name)
    lines = [
        f"# {name}",
        "",
        NOT_BY_HAND.format(name),
        "",
        about,
        "",
        f"![{CAPTIONS[name]}]({picture})",
        "",
        f"*{CAPTIONS[name]}*",
        "",
    ]
    for topic, title in TOPICS.items():
        if topic in topics:
            lines += [f"**{title}.** {sentence(topics[topic])}", ""]
    lines += [
        f"Run it with `debrisflow run cases/{name}.toml`, or start from it with",
        f"`debrisflow init my_case.toml --template {name}`.",
        "",
        "## Parameters",
        "",
        "All other fields have their [defaults](../case_file.md).",
        "",
        "| field | value | unit | meaning |",
        "|---|---|---|---|",
        *rows_of_case(tomllib.loads(text), schema),
        "",
    ]
    return "\n".join(lines)


def picture_of(name: str) -> str:
    """Return the address of the picture of a case, from its page."""
    if name in PICTURES:
        return f"../{VALIDATION.name}/{FIGURES}/{PICTURES[name]}.png"
    return f"../{name}.png" if (DOCS / f"{name}.png").is_file() else f"{name}.png"


def rows_of_case(case: dict[str, Any], schema: dict[str, Any]) -> Iterator[str]:
    """Yield the rows of the table of values that a case file gives."""
    for key, value, prop in values(case, schema["properties"], schema):
        if key.split(".")[0] in NOT_PARAMETERS and key != "time.end":
            continue
        unit = prop.get("unit", "-")
        meaning = meaning_of(value, prop)
        told = json.dumps(value, ensure_ascii=False)
        cells = (f"`{key}`", f"`{told}`", "" if unit == "-" else unit, meaning)
        yield "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def meaning_of(value: Any, prop: dict[str, Any]) -> str:
    """Return what a value means; of a choice only the part on the one that is chosen."""
    meaning: str = prop.get("description", "").removesuffix(f" [{prop.get('unit')}]")
    if "enum" not in prop:
        return meaning
    chosen = re.search(rf"(?:^|; ){re.escape(value)}: ([^;]*)", meaning)
    return chosen[1] if chosen else meaning


def values(
    given: dict[str, Any], properties: dict[str, Any], schema: dict[str, Any], before: str = ""
) -> Iterator[tuple[str, Any, dict[str, Any]]]:
    """Yield key, value and schema of all that is given in a table and in the tables in it."""
    for name, value in given.items():
        prop = properties[name]
        parts = value if isinstance(value, list) else [value]
        if not all(isinstance(part, dict) for part in parts):
            yield before + name, value, prop
            continue
        for number, part in enumerate(parts):
            kinds = branches(prop, schema)
            fits = [kind for kind in kinds if is_of_kind(part, kind)] or kinds
            where = f"{before}{name}.{number}." if isinstance(value, list) else f"{before}{name}."
            yield from values(part, fits[0]["properties"], schema, where)


def is_of_kind(part: dict[str, Any], kind: dict[str, Any]) -> bool:
    """Return whether a table given in a case is one of a kind, by its type and its keys."""
    own = kind["properties"].get("type", {})
    named = part.get("type", own.get("default"))
    return named == own.get("const", own.get("default")) and set(part) <= set(kind["properties"])


def index_of_cases(cases: dict[str, Path]) -> str:
    """Return the page that lists the cases."""
    lines = [
        "# Cases",
        "",
        "<!-- written by scripts/docs.py; do not edit -->",
        "",
        "The shipped cases, from `cases/`. The head of each file says where it comes from, what is",
        "calibrated, what to expect and how long it takes. `debrisflow init FILE --template NAME`",
        'copies one of them. "The study" is described under',
        "[Sources](../sources.md#the-study). Cases with measurements beside them, in",
        "`cases/experiments/`, are on the page [Experiments](../experiments.md).",
        "",
        "| case | what it computes | time it takes |",
        "|---|---|---|",
    ]
    for name, path in cases.items():
        about, topics = head_of(path.read_text(encoding="utf-8"))
        lines.append(f"| [{name}]({name}.md) | {about} | {sentence(topics['Takes'])} |")
    return "\n".join([*lines, ""])


@click.command()
@click.option("--check", is_flag=True, help="Write nothing; fail if a page is out of date.")
def main(check: bool) -> None:
    """Write the generated parts of the documentation."""
    written = pages()
    stale = [
        path
        for path, text in written.items()
        if not path.exists() or path.read_text(encoding="utf-8") != text
    ]
    if check and stale:
        names = ", ".join(str(path.relative_to(ROOT)) for path in stale)
        click.echo(f"out of date: {names}; run: python scripts/docs.py", err=True)
        sys.exit(1)
    for path in stale:
        path.parent.mkdir(exist_ok=True)
        path.write_text(written[path], encoding="utf-8")
        click.echo(f"wrote {path.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
