"""The words of maps and reports in the languages that they can be written in.

English is the key: what ``ja.toml`` does not hold stays English.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.resources import files

LANGUAGES = ("en", "ja")
ENGLISH = "en"


class Words:
    """A translator of English words.

    Parameters
    ----------
    language : str
        One of :data:`LANGUAGES`.

    Examples
    --------
    >>> Words("ja")("Peak flow depth"), Words("en")("Peak flow depth")
    ('最大流動深', 'Peak flow depth')
    """

    def __init__(self, language: str = ENGLISH) -> None:
        self.language = language
        self._known = {} if language == ENGLISH else _table(language)

    def __call__(self, english: str, **values: object) -> str:
        """Return words in the language, with values in the places that they name in braces."""
        text = self._known.get(english, english)
        return text.format(**values) if values else text


@cache
def _table(language: str) -> Mapping[str, str]:
    text = files(__name__).joinpath(f"{language}.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
