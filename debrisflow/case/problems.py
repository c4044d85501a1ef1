"""One problem of a case file and how it is told: key, value, unit, what is wrong or was meant."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple, get_args, get_origin

from pydantic.fields import FieldInfo

from debrisflow.case.fields import NONE, Table
from debrisflow.case.rheology import Rheology, owners
from debrisflow.case.tables import Case
from debrisflow.case.words import ABSENT, did_you_mean, either

Problems = Iterator["Problem"]
LONGEST_VALUE = 60


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


def locate(path: Sequence[str | int]) -> Place:
    """Follow a path of keys through the tables.

    Pydantic names the chosen member of a union in its paths (``geometry, tank, length``); such a
    step is followed but is no key of the file.
    """
    keys: list[str | int] = []
    field: FieldInfo | None = None
    owners: tuple[type[Table], ...] = ()
    tables: tuple[type[Table], ...] = (Case,)
    for step in path:
        chosen = tuple(t for t in tables if step in (t.__name__, _tag(t)))
        if chosen and _is_union(field):
            tables, field = chosen, None
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


def _tag(table: type[Table]) -> str | None:
    """Return the value of ``type`` by which a table is chosen among others."""
    field = table.model_fields.get("type")
    return get_args(field.annotation)[0] if field else None


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


def translate(error: Mapping[str, Any]) -> Problem | None:
    """Return the problem that one error of pydantic stands for.

    Returns None for the second of two errors about one value that may be a table or a text.
    """
    place = locate(error["loc"])
    kind, value = error["type"], error["input"]
    if kind == "extra_forbidden":
        return Problem(
            place.key, _not_of_the_law(place) or "unknown key" + _likely_key(place), value
        )
    if kind == "missing":
        return _missing(place)
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        return _wrong_tag(place, value)
    if kind == "literal_error":
        choices = tuple(_choices(place.field))
        message = f"must be {either(choices)}" + did_you_mean(value, choices)
        return Problem(place.key, message, value)
    if error["loc"][-1] == "str":
        return None
    if error["loc"][-1] in ("Hydrograph", "Motion"):
        return Problem(place.key, "must be a table or the name of a CSV file", value)
    tell = _MESSAGES.get(kind)
    message = tell(error.get("ctx", {}), place) if tell else error["msg"].lower()
    return Problem(place.key, message, value)


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
    """Tell which values of ``type`` there are."""
    known = [
        tag for table in _tables(place.field and place.field.annotation) if (tag := _tag(table))
    ]
    key = f"{place.key}.type"
    if "type" not in value:
        return Problem(key, f"missing: {either(known)}")
    given = value["type"]
    return Problem(key, f"must be {either(known)}" + did_you_mean(given, known), given)


def _choices(field: FieldInfo | None) -> Iterator[str]:
    """Yield the words that a field admits."""
    annotation = field.annotation if field else None
    for member in (annotation, *get_args(annotation)):
        if get_origin(member) is Literal:
            yield from get_args(member)


def _likely_key(place: Place) -> str:
    """Suggest a key of the same table, or the same key of another one."""
    word = str(place.keys[-1])
    here = did_you_mean(word, [name for table in place.owners for name in table.model_fields])
    elsewhere = [key for key in _all_keys(Case) if key.rpartition(".")[2] == word]
    if place.key in elsewhere:
        return " here; it belongs to another type of this table"
    return here or (f"; did you mean '{elsewhere[0]}'?" if elsewhere else "")


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


def _all_keys(table: type[Table], before: str = "") -> Iterator[str]:
    """Yield every dotted key, without those of arrays."""
    for name, field in table.model_fields.items():
        yield before + name
        if get_origin(field.annotation) is not tuple:
            for inner in _tables(field.annotation):
                yield from _all_keys(inner, f"{before}{name}.")


def _list_of(place: Place) -> str:
    """Say which list a field wants."""
    annotation = place.field.annotation if place.field else None
    if any(_tables(annotation)):
        return f"must be an array of tables, each under its own [[{place.key}]]"
    members = {get_args(m) for m in (annotation, *get_args(annotation)) if get_origin(m) is tuple}
    counts = [len(inner) for inner in members if Ellipsis not in inner]
    return f"must be a list of {counts[0]} numbers" if counts else "must be a list of numbers"


_Telling = Callable[[Mapping[str, Any], Place], str]
_MESSAGES: dict[str, _Telling] = {
    "greater_than": lambda limit, _: f"must be greater than {limit['gt']:g}",
    "greater_than_equal": lambda limit, _: f"must be at least {limit['ge']:g}",
    "less_than": lambda limit, _: f"must be less than {limit['lt']:g}",
    "less_than_equal": lambda limit, _: f"must be at most {limit['le']:g}",
    "finite_number": lambda *_: "must be a finite number",
    "float_type": lambda *_: "must be a number",
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
    "too_short": lambda limit, _: f"must have at least {limit['min_length']} entries",
}
