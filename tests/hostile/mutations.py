"""Mutations of the files of a run, each drawn from a generator of random numbers."""

import json
import re
from random import Random

NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?|\bnan\b")
ATTRIBUTE = re.compile(rb'"[^"<>\n]{0,40}"')
ENTITIES = b"".join(
    b'<!ENTITY e%d "%s">' % (k, b"&e%d;" % (k - 1) * 10 if k else b"ha" * 50) for k in range(12)
)
DOCTYPES = (
    b"<!DOCTYPE VTKFile [" + ENTITIES + b"]><VTKFile>&e11;</VTKFile>",
    b'<!DOCTYPE VTKFile [<!ENTITY x SYSTEM "file:///etc/passwd">]><VTKFile>&x;</VTKFile>',
    b'<!DOCTYPE VTKFile SYSTEM "http://127.0.0.1:9/x.dtd"><VTKFile></VTKFile>',
)
NUMBERS = (
    *(b"nan", b"inf", b"-inf", b"1e308", b"-1e308", b"1e-320", b"1e999", b"0", b"-0.0", b"-1"),
    *(b"1", b"2", b"1e12", b"1000000000000", b"2147483648", b"-9223372036854775809", b"9" * 400),
    *(b"", b"x", b"true", b"[]", b"{}", b'"1"', b"0x10", b"1_0", b"1e", b"\xef\xbc\x91"),
)
WORDS = (
    *(b"", b"../../etc/passwd", b"/etc/passwd", b"C:\\x.vtu", b"vtu/../vtu/000000.vtu", b"."),
    *(b"<script>alert(1)</script>", b'\\" onload=\\"', b"$\\\\frac{$", b"{0.__class__}", b"%s%n"),
    *(
        b"\x1b[2J",
        b"\xe2\x80\xae",
        b"\xe2\x80\xa8",
        b"\xf0\x9f\x92\xa9",
        b"\xff",
        b"\0",
        b"a" * 3000,
    ),
    *(b"Float64", b"Int8", b"UInt64", b"String", b"Bit", b"3", b"9", b"appended", b"ascii", b"raw"),
)
ANYTHING = (
    *(None, True, 0, -1, 1e308, 10**30, 1e-300, "", "x", "<script>", [], {}, [1], {"a": 1}, [[]]),
    *(float("nan"), float("inf"), {"a": {"b": []}}, "a" * 5000, "\x1b[2J", {"": 0}),
)


def mutated(data: bytes, random: Random, others: list[bytes]) -> bytes:
    """Return a file with one to three changes.

    Parameters
    ----------
    data : bytes
    random : Random
    others : list of bytes
        Files of which parts are put into it.
    """
    for _ in range(random.choice((1, 1, 2, 3))):
        data = random.choice(CHANGES)(data, random, others)
    return data


def _place(data: bytes, random: Random) -> int:
    return random.randrange(len(data) + 1)


def _bits(data: bytes, random: Random, _: list[bytes]) -> bytes:
    changed = bytearray(data)
    for _bit in range(random.choice((1, 2, 8, 64))):
        if changed:
            changed[random.randrange(len(changed))] ^= 1 << random.randrange(8)
    return bytes(changed)


def _cut(data: bytes, random: Random, _: list[bytes]) -> bytes:
    return data[: _place(data, random)]


def _without_part(data: bytes, random: Random, _: list[bytes]) -> bytes:
    start = _place(data, random)
    return data[:start] + data[start + random.choice((1, 4, 40, 1000)) :]


def _part_twice(data: bytes, random: Random, _: list[bytes]) -> bytes:
    start = _place(data, random)
    end = start + random.choice((1, 4, 40, 1000))
    return data[:end] + data[start:]


def _spliced(data: bytes, random: Random, others: list[bytes]) -> bytes:
    other = random.choice(others)
    return data[: _place(data, random)] + other[_place(other, random) :]


def _whole(data: bytes, random: Random, others: list[bytes]) -> bytes:
    nothing = (b"", b"\0" * 4096, b"\n" * 50, b"[" * 100_000, b"<a>" * 100_000, b"a,b\n", b"{}")
    return random.choice((*nothing, *DOCTYPES, random.choice(others)))


def _encoded(data: bytes, random: Random, _: list[bytes]) -> bytes:
    text = data.decode("utf-8", errors="replace")
    code = random.choice(("utf-16", "utf-8-sig", "utf-32", "utf-16-be", "shift_jis", "cp1252"))
    return text.encode(code, errors="replace")


def _replaced(data: bytes, random: Random, pattern: re.Pattern[bytes], new: bytes) -> bytes:
    """Return data with one or some of the matches of a pattern replaced."""
    found = list(pattern.finditer(data))
    for match in sorted(
        random.sample(found, min(len(found), random.choice((1, 1, 5)))),
        reverse=True,
        key=lambda one: one.start(),
    ):
        data = data[: match.start()] + new + data[match.end() :]
    return data


def _number(data: bytes, random: Random, _: list[bytes]) -> bytes:
    return _replaced(data, random, NUMBER, random.choice(NUMBERS))


def _larger(data: bytes, random: Random, _: list[bytes]) -> bytes:
    found = list(NUMBER.finditer(data))
    if not found:
        return data
    one = random.choice(found)
    return data[: one.end()] + b"000" + data[one.end() :]


def _attribute(data: bytes, random: Random, _: list[bytes]) -> bytes:
    word = random.choice((*WORDS, *NUMBERS))
    return _replaced(data, random, ATTRIBUTE, b'"' + word + b'"')


def _inserted(data: bytes, random: Random, _: list[bytes]) -> bytes:
    start = _place(data, random)
    return data[:start] + random.choice((*WORDS, *NUMBERS)) + data[start:]


def _lines(data: bytes, random: Random, _: list[bytes]) -> bytes:
    lines = data.splitlines(keepends=True)
    if not lines:
        return data
    k, other = random.randrange(len(lines)), random.randrange(len(lines))
    change = random.randrange(4)
    if change == 0:
        del lines[k]
    elif change == 1:
        lines[k], lines[other] = lines[other], lines[k]
    elif change == 2:
        lines.insert(other, lines[k])
    else:
        lines = lines[: k + 1]
    return b"".join(lines)


def _column(data: bytes, random: Random, _: list[bytes]) -> bytes:
    """Remove, double or fill a column of a table."""
    rows = [line.split(b",") for line in data.splitlines()]
    longest = max(map(len, rows), default=0)
    if longest < 2:
        return data
    k, change, value = random.randrange(longest), random.randrange(3), random.choice(NUMBERS)
    for row in rows:
        if len(row) == longest:
            row[k : k + 1] = ([], [row[k]] * 2, [row[k] if row[k][:1].isalpha() else value])[change]
    return b"\n".join(b",".join(row) for row in rows) + b"\n"


def _json(data: bytes, random: Random, _: list[bytes]) -> bytes:
    """Put anything in the place of a value."""
    try:
        found = json.loads(data)
    except ValueError:
        return data
    holder, key = None, None
    node = found
    while isinstance(node, dict | list) and node:
        holder = node
        key = random.choice(list(node)) if isinstance(node, dict) else random.randrange(len(node))
        node = node[key]
        if random.random() < 0.4:
            break
    if holder is None:
        return json.dumps(random.choice(ANYTHING)).encode()
    holder[key] = random.choice(ANYTHING)
    return json.dumps(found).encode()


CHANGES = (
    *(_bits, _cut, _without_part, _part_twice, _spliced, _whole, _encoded),
    *(
        _number,
        _number,
        _number,
        _larger,
        _attribute,
        _attribute,
        _inserted,
        _lines,
        _column,
        _json,
    ),
)
