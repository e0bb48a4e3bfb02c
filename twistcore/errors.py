"""What can go wrong, worded once for a person."""

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
        """Sentence and attributes, whatever __init__ asks for: it must come out of a process."""
        return _remade, (type(self), self.args), vars(self)


def _remade(kind: type[TwistError], arguments: tuple[Any, ...]) -> TwistError:
    """Without __init__, which asks for more than the sentence; the attributes follow."""
    return kind.__new__(kind, *arguments)


class ClipError(TwistError):
    """A clip that cannot be read: where, and what was expected there."""

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
    """A BVH that cannot be read."""


class AmcError(ClipError):
    """An AMC, or the ASF of its skeleton, that cannot be read."""


class NpzError(TwistError):
    """An .npz that cannot be read: it has no lines."""


class ClipMismatchError(TwistError):
    """Two files that should belong together do not."""


class FormatError(TwistError):
    """A JSON or TOML document of ours that is damaged or of another schema."""
