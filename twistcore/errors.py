"""Define the errors that this package raises. Their messages are sentences for users."""

from __future__ import annotations

from typing import Any


class TwistError(Exception):
    """Base class of all errors with a message for users. The message is one sentence.

    Examples
    --------
    >>> import twistcore as tc
    >>> try:
    ...     tc.read_clip("none.bvh")
    ... except tc.TwistError as error:
    ...     print(error)
    none.bvh: expected a BVH file, but the file does not exist
    """

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle the message and attributes, so that other processes can raise the error again.

        Unpickling does not call __init__.
        """
        return _remade, (type(self), self.args), vars(self)


def _remade(kind: type[TwistError], arguments: tuple[Any, ...]) -> TwistError:
    """Create an error without calling __init__, which would need more arguments.

    Pickle then sets the attributes.
    """
    return kind.__new__(kind, *arguments)


class ClipError(TwistError):
    """Raised if a clip cannot be read.

    Parameters
    ----------
    path
        The file.
    expected
        A sentence that describes the expected contents.
    line, column
        The position in the file, from 1, or None if unknown.
    """

    def __init__(
        self, path: str, expected: str, *, line: int | None = None, column: int | None = None
    ) -> None:
        self.path, self.expected, self.line, self.column = path, expected, line, column
        if line is None:
            super().__init__(f"{path}: {expected}")
        elif column is None:
            super().__init__(f"{path}, line {line}: {expected}")
        else:
            super().__init__(f"{path}, line {line}, column {column}: {expected}")


class BvhError(ClipError):
    """Raised if a BVH file cannot be read."""


class AmcError(ClipError):
    """Raised if an AMC file, or the ASF file with its skeleton, cannot be read."""


class NpzError(TwistError):
    """Raised if an .npz file cannot be read. The error has no line number."""


class ClipMismatchError(TwistError):
    """Raised if two files do not belong together, for example a session and a clip."""


class FormatError(TwistError):
    """Raised if a JSON or TOML file of this project is damaged or has an unknown schema."""
