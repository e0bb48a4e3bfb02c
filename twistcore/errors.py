"""Error classes, each with a sentence for a person."""

from __future__ import annotations

from typing import Any


class TwistError(Exception):
    """Base of every error that a person should read: one sentence.

    Examples
    --------
    >>> import twistcore as tc
    >>> try:
    ...     tc.read_clip("none.bvh")
    ... except tc.TwistError as error:
    ...     print(error)
    none.bvh: expected a BVH file, but there is no such file
    """

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickle sentence and attributes without __init__, so that errors can cross processes."""
        return _remade, (type(self), self.args), vars(self)


def _remade(kind: type[TwistError], arguments: tuple[Any, ...]) -> TwistError:
    """Create the error without __init__, which needs more than the sentence; attributes follow."""
    return kind.__new__(kind, *arguments)


class ClipError(TwistError):
    """A clip cannot be read: the place in the file, and what was expected there."""

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
    """A BVH cannot be read."""


class AmcError(ClipError):
    """An AMC, or the ASF with its skeleton, cannot be read."""


class NpzError(TwistError):
    """An .npz cannot be read; it has no line numbers."""


class ClipMismatchError(TwistError):
    """Two files that should belong together do not."""


class FormatError(TwistError):
    """A JSON or TOML document of this project is damaged or has another schema."""
