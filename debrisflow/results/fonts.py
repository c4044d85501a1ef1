"""Which fonts can write Japanese, found among those of the system."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from matplotlib import font_manager

# by family, and as the names of their files begin
JAPANESE = {
    "Noto Sans CJK JP": "notosanscjk-regular",
    "Noto Sans JP": "notosansjp",
    "Source Han Sans JP": "sourcehansansjp-regular",
    "BIZ UDGothic": "bizudgothic-regular",
    "IPAexGothic": "ipaexg",
    "IPAGothic": "ipag.",
    "TakaoGothic": "takaogothic",
    "VL Gothic": "vl-gothic-regular",
    "Hiragino Sans": "ヒラギノ角ゴシック w3",
    "Yu Gothic": "yugothr",
    "Meiryo": "meiryo.",
    "MS Gothic": "msgothic",
}
CLOSING = "、。，：）～"
FIRST_WIDE = 0x2E80  # of the letters of Chinese, Japanese and Korean
# words, single letters of Japanese, and spaces; what closes a sentence stays with what is before
PIECES = re.compile(rf"(?:[^\s\u2e80-\uffff]+|[\u2e80-\uffff])[{CLOSING}]*|\s+")
LATIN = "DejaVu Sans"  # matplotlib brings it along
INSTALL = (
    "no Japanese font was found, so that the labels of pictures are in English.\n"
    "Install one (Debian, Ubuntu: apt install fonts-noto-cjk or fonts-ipaexfont; Fedora: "
    "dnf install google-noto-sans-cjk-fonts; macOS and Windows bring one along) and try again."
)


@cache
def japanese_font() -> str | None:
    """Return the family of a font for Japanese; None if there is none.

    Fonts that were installed after matplotlib made its list are found too.
    """
    known = {font.name for font in font_manager.fontManager.ttflist}
    for family in JAPANESE:
        if family in known:
            return family
    files = [Path(file) for file in font_manager.findSystemFonts()]
    for start in JAPANESE.values():
        for file in files:
            if file.name.lower().startswith(start):
                font_manager.fontManager.addfont(file)
                return str(font_manager.fontManager.ttflist[-1].name)
    return None


def families(language: str = "en") -> list[str]:
    """Return the families for text in a language, the first that has a letter writes it."""
    other = japanese_font()
    if other is None:
        return [LATIN]
    return [other, LATIN] if language == "ja" else [LATIN, other]


def wrapped(text: str, width: int) -> list[str]:
    """Return a text in lines; letters of Japanese are twice as wide and need no space to break.

    Examples
    --------
    >>> wrapped("a flow of mud", 9), wrapped("最大流動深", 6)
    (['a flow of', 'mud'], ['最大流', '動深'])
    """
    lines, line, room = [], "", 0
    for piece in PIECES.findall(text):
        size = sum(1 + (ord(letter) >= FIRST_WIDE) for letter in piece)
        if line and room + size > width:
            lines.append(line.rstrip())
            line, room = "", 0
        if line or not piece.isspace():
            line, room = line + piece, room + size
    return [*lines, line.rstrip()]


def writable(text: str) -> bool:
    """Return whether pictures can show a text: Latin, Greek and the like they always can.

    Examples
    --------
    >>> writable("Débris, φ = 30°")
    True
    """
    return japanese_font() is not None or is_latin(text)


def is_latin(text: str) -> bool:
    """Return whether a text has no letters that only fonts for Japanese and the like hold."""
    return all(ord(letter) < FIRST_WIDE for letter in text)
