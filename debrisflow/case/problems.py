"""One problem of a case file and how it is told: key, value, unit, what is wrong or was meant."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Annotated, Any, Literal, NamedTuple, get_args, get_origin

from pydantic.fields import FieldInfo

from debrisflow.case.fields import NAME_PATTERN, NONE, Table
from debrisflow.case.rheology import Rheology, owners
from debrisflow.case.tables import Case
from debrisflow.case.words import ABSENT, NEAR, did_you_mean, either, nearest

Problems = Iterator["Problem"]
LONGEST_VALUE = 60
CHOOSERS = ("type", "law", "distribution")  # fields by which one of several tables is chosen
LIST = "tuple["  # begins what pydantic calls a kind of list
MOST_SUGGESTED = 3  # keys of other tables
_ENTRY = re.compile(r"\b([a-z]+)\.([0-9]{1,9})\b")


class Problem(NamedTuple):
    """Something wrong with one key of a case.

    Attributes
    ----------
    key : str
        Dotted key, array entries by their index: ``fill.0.x``.
    message : str
        What is wrong, without the key and its value.
    value : object
        The offending value, or ``ABSENT``.
    """

    key: str
    message: str
    value: Any = ABSENT

    def __str__(self) -> str:
        """Return ``key = value unit: message``."""
        if self.value is ABSENT:
            return f"{self.key}: {self.message}"
        unit = unit_of(locate(self.key.split(".")).field)
        return f"{self.key} = {show(self.value)}{unit}: {self.message}"


def by_name(problem: Problem, arrays: Mapping[str, Any]) -> str:
    """Return a problem in which entries of arrays are called by their names, as ``--set`` does.

    Parameters
    ----------
    problem : Problem
    arrays : mapping
        The tables of the case; an entry without a name of its own keeps its index.

    Examples
    --------
    >>> case = {"probe": [{"name": "gauge"}], "fill": [{"type": "block"}]}
    >>> by_name(Problem("probe.0.x", "outside the tank, beside fill.0", 0.5), case)
    'probe.gauge.x = 0.5 m: outside the tank, beside fill.0'
    """
    told = str(problem._replace(message=named(problem.message, arrays)))
    return named(problem.key, arrays) + told.removeprefix(problem.key)


def named(text: str, arrays: Mapping[str, Any]) -> str:
    """Return a text in which entries of arrays are called by their names instead of indices.

    Examples
    --------
    >>> named("probe.0.x", {"probe": [{"name": "gauge"}]})
    'probe.gauge.x'
    """

    def name(match: re.Match[str]) -> str:
        entries, number = arrays.get(match[1]), int(match[2])
        if not isinstance(entries, (list, tuple)) or number >= len(entries):
            return match[0]
        names = [_name(entry) for entry in entries]
        own = names[number]
        return f"{match[1]}.{own}" if own and names.count(own) == 1 else match[0]

    return _ENTRY.sub(name, text)


def _name(entry: Any) -> str | None:
    """Return the name of an entry of an array, None if it has none that a key can hold."""
    name = entry.get("name") if isinstance(entry, Mapping) else getattr(entry, "name", None)
    return name if isinstance(name, str) and re.fullmatch(NAME_PATTERN, name) else None


def was_set(table: Table, name: str) -> bool:
    """Tell whether a field differs from its default, however the file came to state it."""
    return bool(getattr(table, name) != type(table).model_fields[name].default)


class Place(NamedTuple):
    """Where a path leads among the tables: its keys, its field, and the tables that hold it."""

    keys: tuple[str | int, ...]
    field: FieldInfo | None
    owners: tuple[type[Table], ...]

    @property
    def key(self) -> str:
        """The dotted key."""
        return ".".join(map(str, self.keys))


def locate(path: Sequence[str | int], root: type[Table] = Case) -> Place:
    """Follow a path of keys through the tables of a case, or of another kind of file.

    Pydantic names the chosen member of a union in its paths (``geometry, tank, length``, or a kind
    of list beside the name of a file); such a step is followed but is no key of the file.
    """
    keys: list[str | int] = []
    field: FieldInfo | None = None
    owners: tuple[type[Table], ...] = ()
    tables: tuple[type[Table], ...] = (root,)
    for step in path:
        chosen = tuple(t for t in tables if step in (t.__name__, _tag(t)))
        if chosen and _is_union(field):
            tables, field = chosen, None
            continue
        if str(step).startswith(LIST):
            continue
        keys.append(step)
        if isinstance(step, int) or step.isdecimal():
            continue
        owners = tables
        field = next((t.model_fields[step] for t in tables if step in t.model_fields), None)
        tables = tuple(_tables(field.annotation)) if field else ()
    return Place(tuple(keys), field, owners)


def _tables(annotation: Any) -> Iterator[type[Table]]:
    """Yield the tables that an annotation admits, through unions, tuples and metadata."""
    if isinstance(annotation, type) and issubclass(annotation, Table):
        yield annotation
    for inner in get_args(annotation):
        yield from _tables(inner)


def _chooser(table: type[Table]) -> str | None:
    """Return the field by which a table is chosen among others: one that admits one word."""
    for name in CHOOSERS:
        field = table.model_fields.get(name)
        if field is not None and len(get_args(field.annotation)) == 1:
            return name
    return None


def _tag(table: type[Table]) -> str | None:
    """Return the word by which a table is chosen among others."""
    name = _chooser(table)
    return get_args(table.model_fields[name].annotation)[0] if name else None


def _is_union(field: FieldInfo | None) -> bool:
    """Tell whether pydantic names a member of the field's type in its paths."""
    if field is None:
        return False
    return len(list(_tables(field.annotation))) > 1 or str in get_args(field.annotation)


def unit_of(field: FieldInfo | None) -> str:
    """Return a field's unit with a blank before it, empty for a number without one."""
    extra = field.json_schema_extra if field else None
    unit = extra.get("unit", NONE) if isinstance(extra, dict) else NONE
    return "" if unit == NONE else f" {unit}"


def show(value: Any) -> str:
    """Return a value as it stands in a case file, shortened where it is long."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, str):
        text = f'"{value}"'
    elif isinstance(value, Mapping):
        text = "{" + ", ".join(f"{key} = {show(item)}" for key, item in value.items()) + "}"
    elif isinstance(value, (list, tuple)):
        text = "[" + ", ".join(map(show, value)) + "]"
    else:
        text = str(value)
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 4] + " ..."


def translate(
    error: Mapping[str, Any], data: Mapping[str, Any], root: type[Table] = Case
) -> Problem | None:
    """Return the problem that one error of pydantic, about the data of a case, stands for.

    Returns None for an error that only repeats others: the second one about a value that may be
    of two kinds, and that of a list whose entries are wrong, which pydantic does not count.
    """
    place = locate(error["loc"], root)
    kind, value = error["type"], error["input"]
    if kind == "too_short" and len(value) >= error["ctx"]["min_length"]:
        return None
    if _is_of_second_kind(error["loc"], place):
        return None
    if kind == "extra_forbidden":
        message = _not_of_the_law(place) or "unknown key" + _likely_key(place, value, data, root)
        return Problem(place.key, message, value)
    if kind == "missing":
        return _missing(place)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _wrong_tag(place, value)
    if kind == "literal_error":
        choices = tuple(_choices(place.field))
        message = f"must be {either(choices)}" + did_you_mean(value, choices)
        return Problem(place.key, message, value)
    if error["loc"][-1:] == ("str",):
        return None
    if error["loc"][-1:] in (("Hydrograph",), ("Motion",)):
        return Problem(place.key, "must be a table or the name of a CSV file", value)
    tell = _MESSAGES.get(kind)
    message = tell(error.get("ctx", {}), place) if tell else error["msg"].lower()
    return Problem(place.key, message, value)


def _is_of_second_kind(path: Sequence[str | int], place: Place) -> bool:
    """Tell whether an error is about a list of words that may be one of numbers as well."""
    of_words = any(str(step).startswith(f"{LIST}str") for step in path)
    return of_words and _entries(place.field) == {str, float}


def _entries(field: FieldInfo | None) -> set[Any]:
    """Return the types of the entries that a field's list of any length may have."""
    kinds = [get_args(kind) for kind in _plain(field and field.annotation)]
    return {kind[0] for kind in kinds if Ellipsis in kind}


def _missing(place: Place) -> Problem:
    """Tell what is missing: a number of a list, a table or a field."""
    if isinstance(place.keys[-1], int):
        return Problem(place.key, "missing; " + _list_of(place))
    if place.field and any(_tables(place.field.annotation)):
        return Problem(place.key, f"missing table [{place.key}]")
    meaning = place.field.description if place.field else ""
    unit = unit_of(place.field).strip()
    return Problem(place.key, f"missing: {meaning}" + (f" ({unit})" if unit else ""))


def _wrong_tag(place: Place, value: Any) -> Problem:
    """Tell by which words a table is chosen."""
    tables = list(_tables(place.field and place.field.annotation))
    known = [tag for table in tables if (tag := _tag(table))]
    name = next(filter(None, map(_chooser, tables)), CHOOSERS[0])
    key = f"{place.key}.{name}"
    if name not in value:
        return Problem(key, f"missing: {either(known)}")
    given = value[name]
    return Problem(key, f"must be {either(known)}" + did_you_mean(given, known), given)


def _choices(field: FieldInfo | None) -> Iterator[str]:
    """Yield the words that a field admits."""
    annotation = field.annotation if field else None
    for member in (annotation, *get_args(annotation)):
        if get_origin(member) is Literal:
            yield from get_args(member)


def _likely_key(place: Place, value: Any, data: Mapping[str, Any], root: type[Table]) -> str:
    """Suggest a key of the same table, or one of the same or a like name in other tables."""
    word = str(place.keys[-1])
    here = did_you_mean(word, [name for table in place.owners for name in table.model_fields])
    known = dict.fromkeys(_all_keys(root, data, is_table=isinstance(value, Mapping)))
    if place.key in known:
        return " here; it belongs to another type of this table"
    names = {key.rpartition(".")[2] for key in known}
    likely = word if word in names else nearest(word, names, in_part=NEAR)
    elsewhere = [key for key in known if key.rpartition(".")[2] == likely]
    if here or not 0 < len(elsewhere) <= MOST_SUGGESTED:
        return here
    return f"; did you mean {either(elsewhere)}?"


def _not_of_the_law(place: Place) -> str | None:
    """Return what to do with a field of a rheological law beside another one; None for others."""
    if not (place.owners and issubclass(place.owners[0], Rheology)):
        return None
    name = str(place.keys[-1])
    if name == "saturated":
        return f"a dry mass needs friction: rheology.type must be {either(owners(name))}"
    if owners(name):
        return f"has no effect with the law '{_tag(place.owners[0])}'; leave it out"
    return None


def _all_keys(table: type[Table], data: Any, is_table: bool, before: str = "") -> Iterator[str]:
    """Yield every dotted key of a table, or of a value, without those of arrays.

    Tables that may be left out have keys only where the case gives them.
    """
    for name, field in table.model_fields.items():
        inner = [] if get_origin(field.annotation) is tuple else list(_tables(field.annotation))
        if bool(inner) == is_table:
            yield before + name
        given = data.get(name) if isinstance(data, Mapping) else None
        if field.default is None and given is None:
            continue
        for one in inner:
            yield from _all_keys(one, given, is_table, f"{before}{name}.")


def _list_of(place: Place) -> str:
    """Say which list a field wants."""
    annotation = place.field.annotation if place.field else None
    if any(_tables(annotation)):
        return f"must be an array of tables, each under its own [[{place.key}]]"
    entries = _entries(place.field)
    if str in entries:
        other = "text in quotes" if str in _plain(annotation) else "a list of numbers"
        return f"must be {other}, or a list of texts"
    members = {get_args(m) for m in _plain(annotation) if get_origin(m) is tuple}
    counts = [(len(inner), inner[0] is float) for inner in members if Ellipsis not in inner]
    if not counts:
        return "must be a list of numbers"
    count, of_numbers = counts[0]
    listed = f"must be a list of {count} {'numbers' if of_numbers else 'points'}"
    return f"{listed}, or the name of a file" if str in _plain(annotation) else listed


def _plain(annotation: Any) -> set[Any]:
    """Return a type and the members of it if it is a union, without their metadata."""
    members = {annotation, *get_args(annotation)}
    return members | {get_args(m)[0] for m in members if get_origin(m) is Annotated}


_Telling = Callable[[Mapping[str, Any], Place], str]
_MESSAGES: dict[str, _Telling] = {
    "greater_than": lambda limit, _: f"must be greater than {limit['gt']:g}",
    "greater_than_equal": lambda limit, _: f"must be at least {limit['ge']:g}",
    "less_than": lambda limit, _: f"must be less than {limit['lt']:g}",
    "less_than_equal": lambda limit, _: f"must be at most {limit['le']:g}",
    "multiple_of": lambda limit, _: f"must be a multiple of {limit['multiple_of']:g}",
    "finite_number": lambda *_: "must be a finite number",
    "float_type": lambda _, place: (
        "must be a number" + (", or all must be text" if str in _entries(place.field) else "")
    ),
    "int_type": lambda *_: "must be a whole number",
    "bool_type": lambda *_: "must be true or false",
    "string_type": lambda *_: "must be text in quotes",
    "model_type": lambda *_: "must be a table",
    "model_attributes_type": lambda *_: "must be a table",
    "string_pattern_mismatch": lambda *_: (
        "must be small letters, digits and underscores, first a letter"
    ),
    "tuple_type": lambda _, place: _list_of(place),
    "too_long": lambda _, place: _list_of(place),
    "value_error": lambda fault, _: str(fault["error"]),
    "too_short": lambda limit, _: f"must have at least {limit['min_length']} entries",
}
