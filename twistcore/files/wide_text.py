"""Text in UTF-16 or UTF-32, as a shell's redirect or an editor saves it: recognised and undone."""

from __future__ import annotations

import codecs
from dataclasses import dataclass, field

_MARKS = (  # UTF-32's mark begins as UTF-16's does, so it is looked for first
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_WIDTHS = {"utf-16-le": 2, "utf-16-be": 2, "utf-32-le": 4, "utf-32-be": 4}
_LETTERS = 4  # of a text without a mark that must be ASCII: a film begins like the first one
_PRINTED = frozenset(b"\t\n\r") | frozenset(range(32, 127))


@dataclass(frozen=True)
class WideText:
    """A file's bytes as UTF-8, its mark included, and what is needed to write them back.

    codec: 'utf-16-le' or the like; rest: bytes at the end that are no whole character.
    """

    text: bytes = field(repr=False)
    codec: str
    rest: bytes = b""

    @property
    def name(self) -> str:
        """'UTF-16' or 'UTF-32'."""
        return self.codec[:6].upper()

    def encoded(self, text: bytes) -> bytes:
        """A changed text, UTF-8, in the file's own encoding: the reverse of :func:`wide_text`."""
        return text.decode("utf-8", "surrogatepass").encode(self.codec, "surrogatepass") + self.rest


def wide_text(data: bytes) -> WideText | None:
    """The text of a file in UTF-16 or UTF-32, with or without a mark; None for any other file.

    Raises UnicodeDecodeError where UTF-32 has a number that is no character.
    """
    codec = wide_codec(data)
    if codec is None:
        return None
    end = len(data) - len(data) % _WIDTHS[codec]
    # Half of a surrogate pair is kept: nothing that is read here is lost when it is written.
    text = data[:end].decode(codec, "surrogatepass").encode("utf-8", "surrogatepass")
    return WideText(text, codec, data[end:])


def wide_codec(data: bytes) -> str | None:
    """The codec of a text in UTF-16 or UTF-32 by its first bytes; None for any other."""
    marked = next((codec for mark, codec in _MARKS if data.startswith(mark)), None)
    return marked or next((codec for codec in _WIDTHS if _is_ascii(data, codec)), None)


def wide_instead(data: bytes) -> str | None:
    """A sentence for a reader that takes no UTF-16 or UTF-32, where a file is such."""
    codec = wide_codec(data)
    if codec is None:
        return None
    return f"expected text in UTF-8 or ASCII, found {codec[:6].upper()}; save it as UTF-8"


def narrow_head(head: bytes) -> bytes:
    """The first bytes of a file as UTF-8 where they are UTF-16 or UTF-32, else as they are."""
    codec = wide_codec(head)
    return head if codec is None else head.decode(codec, "ignore").encode("utf-8", "ignore")


def _is_ascii(data: bytes, codec: str) -> bool:
    """Whether the first letters of a text without a mark are ASCII in this encoding."""
    width = _WIDTHS[codec]
    some = data[: _LETTERS * width]
    if len(some) < _LETTERS * width or 0 not in some:  # a decoder takes a while to load
        return False
    try:
        letters = some.decode(codec)
    except UnicodeDecodeError:
        return False
    return all(ord(letter) in _PRINTED for letter in letters)
