"""Mutations of files and of the tables of a case, each drawn from a generator of random numbers."""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Sequence
from copy import deepcopy
from datetime import date, time
from random import Random
from typing import Any

import tomli_w

DEEP = 200
LONG = 3000


def _nested(depth: int) -> list[Any]:
    inner: list[Any] = []
    for _ in range(depth):
        inner = [inner]
    return inner


EXTREMES: tuple[Any, ...] = (
    *(0, -0.0, -1, 1, 2, 3, 0.5, 1000.0, 0.001, True, False),
    *(2**31, 2**53, 2**63 - 1, 2**63, -(2**64), 10**400, 10**4000),
    *(1e6, 1e9, 1e15, 1e16, 1e30, 1e154, 1e300, 1.7e308, -1.7e308, 1e-9, 1e-15, 1e-160, 5e-324),
    *(float("nan"), float("inf"), float("-inf")),
    *("", " ", "x", "x" * LONG, "nul\0", "é\u202e\ufeff", "1e999", "%s{0}"),
    *(".", "..", "/", "/dev/zero", "/dev/stdin", "/proc/self/mem", "absent", "a" * 300 + ".csv"),
    *("/vsicurl/http://127.0.0.1:9/a.tif", "/vsizip/a.zip/a.tif", "zip://a.zip!a.shp"),
    *([], {}, [[]], [{}], [None], [0], [0, 0], [1, 0], [[0, 0], [0, 0]], [1e308, -1e308]),
    *(_nested(20), _nested(DEEP), date(2000, 1, 1), time(1, 2, 3)),
)
"""What may stand in the place of any value."""
LINES = (
    *(b"nan", b"inf", b"-inf", b"1e400", b"1e-400", b"0x10", b"1_0", b"9" * 5000, b"1e308", b"-1"),
    *(b"", b",", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"\r", b'"', b"#", b"=", b"[", b"{" * 2000),
    *(b"[" * 5000, b"a." * 5000, b"4294967295", b"1000000000", b"-2147483648", b"<!ENTITY a 'b'>"),
)
"""What may be put into a file, among the words that its kind has."""

Words = Sequence[bytes]


def mutated(data: bytes, random: Random, words: Words = ()) -> bytes:
    """Return a file with one to four changes to its bytes, lines or words."""
    for _ in range(random.randint(1, 4)):
        data = random.choice(CHANGES)(data, random, words)
    return data


def _cut(data: bytes, random: Random, _: Words) -> bytes:
    return data[: random.randint(0, len(data))]


def _without_part(data: bytes, random: Random, _: Words) -> bytes:
    start = random.randint(0, len(data))
    return data[:start] + data[start + random.randint(1, 40) :]


def _bits_turned(data: bytes, random: Random, _: Words) -> bytes:
    changed = bytearray(data)
    for _ in range(random.randint(1, 8) if changed else 0):
        changed[random.randrange(len(changed))] = random.choice(
            (0, 255, 127, random.randrange(256))
        )
    return bytes(changed)


def _number_overwritten(data: bytes, random: Random, _: Words) -> bytes:
    """Overwrite two, four or eight bytes by a number, as the header of a binary file has them."""
    size = random.choice((2, 4, 8))
    value = random.choice((0, 1, 2 ** (8 * size - 1) - 1, 2 ** (8 * size) - 1, 2 ** (4 * size)))
    start = random.randint(0, max(len(data) - size, 0))
    order = random.choice(("little", "big"))
    return data[:start] + value.to_bytes(size, order) + data[start + size :]


def _word_put_in(data: bytes, random: Random, words: Words) -> bytes:
    start = random.randint(0, len(data))
    word = random.choice(random.choice((words or LINES, LINES)))
    return data[:start] + word + data[start + random.choice((0, 0, len(word))) :]


def _word_replaced(data: bytes, random: Random, words: Words) -> bytes:
    parts = data.split(random.choice((b" ", b",", b"\n")))
    if len(parts) < 2:
        return data
    old = random.choice(parts)
    new = random.choice(random.choice((words or LINES, LINES)))
    return data.replace(old, new, 1) if old else data


def _line_again(data: bytes, random: Random, _: Words) -> bytes:
    lines = data.split(b"\n")
    lines.insert(random.randint(0, len(lines)), random.choice(lines))
    return b"\n".join(lines)


def _line_gone(data: bytes, random: Random, _: Words) -> bytes:
    lines = data.split(b"\n")
    del lines[random.randrange(len(lines))]
    return b"\n".join(lines)


def _encoded_otherwise(data: bytes, random: Random, _: Words) -> bytes:
    text = data.decode("utf-8", "replace")
    return text.encode(random.choice(("utf-16", "utf-16-le", "utf-8-sig", "latin-1")), "replace")


CHANGES: tuple[Callable[[bytes, Random, Words], bytes], ...] = (
    _cut,
    _without_part,
    _bits_turned,
    _number_overwritten,
    _word_put_in,
    _word_replaced,
    _line_again,
    _line_gone,
    _encoded_otherwise,
)


def mutated_case(data: bytes, random: Random, words: Words = ()) -> bytes:
    """Return a case file changed in its tables, or where it has none in its bytes."""
    if random.random() < 0.25:
        return mutated(data, random, words)
    try:
        tables = tomllib.loads(data.decode())
    except (ValueError, RecursionError):
        return mutated(data, random, words)
    try:
        return tomli_w.dumps(mutated_tables(tables, random, words)).encode("utf-8", "replace")
    except (ValueError, TypeError, RecursionError):
        return mutated(data, random, words)


def mutated_tables(tables: dict[str, Any], random: Random, words: Words = ()) -> dict[str, Any]:
    """Return tables with one to three changes of values, keys and entries."""
    tables = deepcopy(tables)
    for _ in range(random.randint(1, 3)):
        places = list(_places(tables))
        if not places:
            break
        holder, key = random.choice(places)
        _change(holder, key, random, words)
    return tables


def _places(node: Any) -> Iterator[tuple[Any, Any]]:
    """Yield every value of nested tables by what holds it and its key there."""
    keys = list(node) if isinstance(node, dict) else range(len(node))
    for key in keys:
        yield node, key
        if isinstance(node[key], dict | list):
            yield from _places(node[key])


def _change(holder: Any, key: Any, random: Random, words: Words) -> None:
    value = holder[key]
    how = random.random()
    if isinstance(value, float | int) and not isinstance(value, bool) and how < 0.4:
        factors = (-1, 0.001, 1000.0, 1e-6, 1e6, 0.9, 1.1, 0.5, 2.0, 1e12, 1e-12)
        holder[key] = min(max(value, -1e300), 1e300) * random.choice(factors)
    elif how < 0.7:
        holder[key] = deepcopy(random.choice(EXTREMES))
    elif how < 0.8:
        del holder[key]
    elif how < 0.9 and isinstance(holder, list):
        holder.insert(key, deepcopy(value))
    elif isinstance(holder, dict) and words:
        name = random.choice(words).decode("utf-8", "replace")
        holder[name] = deepcopy(random.choice((value, *EXTREMES)))
    elif words:
        holder[key] = random.choice(words).decode("utf-8", "replace")
