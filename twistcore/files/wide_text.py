"""Recognise and decode text in UTF-16 or UTF-32, which shells and some editors write."""

from __future__ import annotations

import codecs
from dataclasses import dataclass, field

_MARKS = (  # UTF-32 is first, because its mark begins with the mark of UTF-16
    (codecs.BOM_UTF32_LE, "utf-32-le"),
    (codecs.BOM_UTF32_BE, "utf-32-be"),
    (codecs.BOM_UTF16_LE, "utf-16-le"),
    (codecs.BOM_UTF16_BE, "utf-16-be"),
)
_WIDTHS = {"utf-16-le": 2, "utf-16-be": 2, "utf-32-le": 4, "utf-32-be": 4}
_LETTERS = 4  # number of characters that must be ASCII in a text without a mark
_PRINTED = frozenset(b"\t\n\r") | frozenset(range(32, 127))


@dataclass(frozen=True)
class WideText:
    """The text of a file in UTF-16 or UTF-32, converted to UTF-8.

    Attributes
    ----------
    text
        The text in UTF-8, with its byte order mark.
    codec
        The codec of the file, such as 'utf-16-le'.
    rest
        Bytes at the end of the file that do not form a complete character.
    """

    text: bytes = field(repr=False)
    codec: str
    rest: bytes = b""

    @property
    def name(self) -> str:
        """The name of the encoding, 'UTF-16' or 'UTF-32'."""
        return self.codec[:6].upper()

    def encoded(self, text: bytes) -> bytes:
        """Convert changed text from UTF-8 to the file's encoding."""
        return text.decode("utf-8", "surrogatepass").encode(self.codec, "surrogatepass") + self.rest


def decode_utf16_or_utf32(data: bytes) -> WideText | None:
    """Decode a file in UTF-16 or UTF-32, with or without a byte order mark.

    The result is None for other encodings. Raises UnicodeDecodeError if UTF-32 contains a number
    that is not a character.
    """
    codec = utf16_or_utf32_codec(data)
    if codec is None:
        return None
    end = len(data) - len(data) % _WIDTHS[codec]
    # An unpaired surrogate is kept, so that writing the text gives the same bytes.
    text = data[:end].decode(codec, "surrogatepass").encode("utf-8", "surrogatepass")
    return WideText(text, codec, data[end:])


def utf16_or_utf32_codec(data: bytes) -> str | None:
    """Return the codec of text in UTF-16 or UTF-32 from its first bytes, or None."""
    marked = next((codec for mark, codec in _MARKS if data.startswith(mark)), None)
    return marked or next((codec for codec in _WIDTHS if _is_ascii(data, codec)), None)


def utf16_or_utf32_message(data: bytes) -> str | None:
    """Return an error message if a file is in UTF-16 or UTF-32, or None if it is not.

    The message is used by readers that do not accept these encodings.
    """
    codec = utf16_or_utf32_codec(data)
    if codec is None:
        return None
    return f"expected text in UTF-8 or ASCII, found {codec[:6].upper()}; save it as UTF-8"


def first_bytes_as_utf8(head: bytes) -> bytes:
    """Return the first bytes of a file, converted to UTF-8 if they are in UTF-16 or UTF-32."""
    codec = utf16_or_utf32_codec(head)
    return head if codec is None else head.decode(codec, "ignore").encode("utf-8", "ignore")


def _is_ascii(data: bytes, codec: str) -> bool:
    """Return True if the first characters are printable ASCII when decoded with this codec."""
    width = _WIDTHS[codec]
    some = data[: _LETTERS * width]
    if len(some) < _LETTERS * width or 0 not in some:  # a decoder takes a while to load
        return False
    try:
        letters = some.decode(codec)
    except UnicodeDecodeError:
        return False
    return all(ord(letter) in _PRINTED for letter in letters)
