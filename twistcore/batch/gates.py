"""Parse and check rules for a batch, such as `--fail-if "count[limb-flip]>0"`."""

from __future__ import annotations

import math
import operator
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from twistcore.batch.manifest import ClipRecord
from twistcore.detection import Kind
from twistcore.errors import TwistError

GRAMMAR = """\
A rule states what must not happen: "severity>5" fails if a clip's severity is above 5.

  [total.]WHAT[FILTER,…] OP NUMBER      in quotes, because > is special in a shell

WHAT      severity        how bad a clip is, in degrees: root mean square over its frames
          count           intervals; noise, frozen frames, stretches, turned ends, spikes, backward
                          bends, joint and place jumps and body steps only if [ ] includes them
          degrees         the largest delta_deg of an interval; for a lone jump, its turn in one
                          frame; with [noise-burst], σ of the noise
          affected        frames with a correctable error, in percent: affected>2%;
                          frames with other errors only if [ ] includes their kind
          missing-frames  frames that the file's header declares but the file does not have
          unexamined      arms and legs that were not examined: unexamined>0
          failed          clips of the whole run that could not be processed: failed>0
          unchecked       clips that could not be examined: no chain, too few frames
FILTER    in [ ] after count, degrees or affected, separated by commas; all must be met:
          a kind (counter-twist, carried-roll, limb-flip, helper-roll, lone-jump, stretch,
          turned-end, spike, backward-bend, joint-jump, place-jump, body-step, noise-burst,
          frozen-frames; if several are given, any of them), or
          confidence OP NUMBER
OP        >  >=  <  <=  ==

A rule applies to every clip. With "total." it applies to the whole run: counts are added up,
degrees is the largest, and affected and severity refer to the frames of all clips. A clip that
could not be processed is listed as such and breaks only the rule "failed".

Examples  severity>5   count[limb-flip]>0   count[confidence>=0.8]>3   affected>2%
          degrees[counter-twist,confidence>=0.9]>10   total.count>100   failed>0
          missing-frames>0   unexamined>0
"""

_OPERATORS: Mapping[str, Callable[[float, float], bool]] = {
    ">=": operator.ge,
    "<=": operator.le,
    "==": operator.eq,
    ">": operator.gt,
    "<": operator.lt,
}
_OF_INTERVALS = ("count", "degrees", "affected")
_OF_CLIPS = ("failed", "unchecked")  # counted over the run
_MISSING = "missing-frames"
_WHAT = ("severity", *_OF_INTERVALS, _MISSING, "unexamined", *_OF_CLIPS)
_KINDS = {kind.value.replace(" ", "-"): kind for kind in Kind}
_OP = "|".join(map(re.escape, _OPERATORS))
_RULE = re.compile(
    rf"(?P<total>total\.)?(?P<what>\w[\w-]*)\s*(?:\[(?P<filters>[^\[\]]*)\])?"
    rf"\s*(?P<op>{_OP})\s*(?P<limit>[^\s%]+)\s*(?P<percent>%?)"
)
_CONFIDENCE = re.compile(rf"confidence\s*({_OP})\s*(\S+)")


@dataclass(frozen=True)
class Rule:
    """A parsed rule, which limits a quantity of each clip or of the whole run.

    Parameters
    ----------
    text
        The rule as the user wrote it.
    what
        The quantity, such as 'count' or 'severity'.
    total
        True if the rule applies to the whole run instead of each clip.
    kinds
        The kinds of intervals to which the rule applies, empty for all.
    confidence
        Pairs of operator and limit for an interval's confidence, all of which must be met.
    op
        The operator with which a value is compared with the limit.
    limit
        The limit of the quantity; for `affected`, in per cent.
    """

    text: str
    what: str
    total: bool
    kinds: frozenset[Kind]
    confidence: tuple[tuple[str, float], ...]
    op: str
    limit: float

    def counts(self, interval: Mapping[str, Any]) -> bool:
        """Return True if the rule applies to an interval, given as an entry of `detect --json`.

        An interval without a confidence counts as having confidence 1.
        """
        kind = Kind(interval["kind"])
        if kind not in self.kinds if self.kinds else kind.of_capture:
            return False
        sure = 1.0 if interval["confidence"] is None else float(interval["confidence"])
        return all(_OPERATORS[op](sure, limit) for op, limit in self.confidence)

    def broken_by(self, value: float) -> bool:
        """Return True if a value breaks the rule."""
        return _OPERATORS[self.op](value, self.limit)


@dataclass(frozen=True)
class Broken:
    """A rule that a clip or the whole run breaks.

    Parameters
    ----------
    rule
        The rule.
    clip
        Name of the clip, or '' for the whole run.
    value
        The value that breaks the rule.
    """

    rule: Rule
    clip: str
    value: float

    def __str__(self) -> str:
        unit = {"severity": "°", "degrees": "°", "affected": " %"}.get(self.rule.what, "")
        who = self.clip or "all clips"
        found = f"{self.rule.what} is {self.value:.4g}{unit}"
        return f"{who}: {found}, which breaks the rule {self.rule.text!r}"


def parse_batch_rule(text: str) -> Rule:
    """Parse a rule in the syntax of :data:`GRAMMAR`. Raises TwistError if the syntax is wrong."""

    def refused(expected: str) -> TwistError:
        return TwistError(f"rule {text!r}: expected {expected}")

    found = _RULE.fullmatch(text.strip())
    if found is None:
        raise refused("WHAT, one of > >= < <= ==, and a number, as in 'count[limb-flip]>0'")
    what, total = found["what"], bool(found["total"])
    if what not in _WHAT:
        raise refused(f"one of {', '.join(_WHAT)}, found {what!r}")
    limit = _number(found["limit"])
    if limit is None:
        raise refused(f"a number after {found['op']!r}, found {found['limit']!r}")
    if bool(found["percent"]) != (what == "affected"):
        raise refused("a percentage, as in 'affected>2%'" if what == "affected" else "no '%'")
    if found["filters"] is not None and what not in _OF_INTERVALS:
        raise refused(f"a filter only for {', '.join(_OF_INTERVALS)}, found one for {what}")
    kinds, confidence = set(), []
    for word in () if found["filters"] is None else found["filters"].split(","):
        word = word.strip()
        at_least = _CONFIDENCE.fullmatch(word)
        edge = _number(at_least[2]) if at_least else None
        if at_least and edge is not None:
            confidence.append((at_least[1], edge))
        elif (kind := _KINDS.get("-".join(word.lower().split()))) is not None:
            kinds.add(kind)
        else:
            raise refused(f"{', '.join(_KINDS)} or confidence>=0.8 in [ ], found {word!r}")
    return Rule(
        text.strip(),
        what,
        total or what in _OF_CLIPS,
        frozenset(kinds),
        tuple(confidence),
        found["op"],
        limit,
    )


def broken_rules(rules: Sequence[Rule], records: Iterable[ClipRecord]) -> list[Broken]:
    """Return all broken rules: those of single clips, in order, and then those of the whole run.

    `records` is iterated only once, so it may be a generator.
    """
    of_clips = [rule for rule in rules if not rule.total]
    totals = {rule: _Total() for rule in rules if rule.total}
    out = []
    for record in records:
        for total in totals.values():
            total.failed += record.state == "failed"
        if record.state != "done" or record.result is None:
            continue
        values = [(rule, _of_clip(rule, record.result)) for rule in of_clips]
        out += [Broken(rule, record.name, v) for rule, v in values if rule.broken_by(v)]
        for rule, total in totals.items():
            total.add(rule, record.result)
    values = [(rule, total.value(rule)) for rule, total in totals.items()]
    return out + [Broken(rule, "", v) for rule, v in values if rule.broken_by(v)]


@dataclass
class _Total:
    """Running totals over one or more clips, from which the quantity of a rule is computed."""

    failed: int = 0
    unchecked: int = 0
    count: int = 0
    degrees: float = 0.0
    frames: int = 0
    affected: int = 0
    missing: int = 0
    unexamined: int = 0
    squares: float = 0.0  # squared severity, degrees², summed over frames

    def add(self, rule: Rule, result: Mapping[str, Any]) -> None:
        sizes = list(_sizes(rule, result))
        self.count += len(sizes)
        self.unchecked += bool(result["unchecked"])
        self.degrees = max(self.degrees, *sizes, 0.0)
        self.frames += result["frames"]
        self.affected += _affected(rule, result)
        self.missing += result.get("missing_frames") or 0
        self.unexamined += len(result.get("unexamined") or ())
        self.squares += result["severity"] ** 2 * result["frames"]

    def value(self, rule: Rule) -> float:
        frames = max(self.frames, 1)
        values = {
            "failed": self.failed,
            "unchecked": self.unchecked,
            "count": self.count,
            "degrees": self.degrees,
            "affected": 100.0 * self.affected / frames,
            _MISSING: self.missing,
            "unexamined": self.unexamined,
            "severity": math.sqrt(self.squares / frames),
        }
        return values[rule.what]


def _of_clip(rule: Rule, result: Mapping[str, Any]) -> float:
    total = _Total()
    total.add(rule, result)
    return float(result["severity"]) if rule.what == "severity" else total.value(rule)


def _sizes(rule: Rule, result: Mapping[str, Any]) -> Iterator[float]:
    """Yield the size in degrees of each interval to which the rule applies.

    The size is the offset. For a kind of error without an offset, it is the rotation within one
    frame or the noise level.
    """
    for interval in result["intervals"]:
        if rule.counts(interval):
            own = interval.get(Kind(interval["kind"]).info.size, 0.0)
            yield abs(float(own or 0.0))


def _affected(rule: Rule, result: Mapping[str, Any]) -> int:
    """Return the number of frames covered by the intervals to which the rule applies.

    Kinds of errors that cannot be corrected are included only if the rule names them.
    """
    if not (rule.kinds or rule.confidence):
        return int(result["affected_frames"])
    kinds = rule.kinds or {kind for kind in Kind if kind.repairable}
    counted = (i for i in result["intervals"] if rule.counts(i) and i["kind"] in kinds)
    spans = sorted((i["start"], i["stop"]) for i in counted)
    frames, reached = 0, 0
    for start, stop in spans:
        frames += max(0, stop - max(start, reached))
        reached = max(reached, stop)
    return frames


def _number(text: str) -> float | None:
    """Convert a string to a number. Return None if it is not a finite number."""
    try:
        value = float(text)
    except ValueError:
        return None
    return value if math.isfinite(value) else None
