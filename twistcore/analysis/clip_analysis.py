"""Analyse a clip: find chains, compute signals and run detectors, each only when needed."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial
from importlib import import_module
from threading import Lock
from types import MappingProxyType
from typing import Any, TypeVar, overload
from weakref import WeakKeyDictionary

from twistcore.analysis.correction.protected_measures import (
    Hinges,
    ProtectedMeasure,
    protected_measures,
    restrict_interval_to_frames,
)
from twistcore.analysis.correction.twist_removal import automatic_corrections, refine, refiner
from twistcore.analysis.examination import (
    unexamined_limbs,
    unexamined_segments_note,
    why_not_examined,
)
from twistcore.detection import DEFAULT_METHOD, DETECTORS, Analysis, Detector, Interval, Kind
from twistcore.detection.all_joints.body_steps import BodyStep, body_steps
from twistcore.detection.capture_faults import (
    bursts_outside_chains,
    frozen_spans_sentence,
    is_at_body_step,
)
from twistcore.detection.carried_rolls import (
    CarriedRolls,
    CarriedRollTest,
    analyse_rolls_carried_to_child,
)
from twistcore.detection.constant_offsets import constant_offsets, constant_offsets_from_other_take
from twistcore.detection.cuts import ignored_frames_notes
from twistcore.detection.finding import KindSearch, intervals_of_kind
from twistcore.detection.helper_rolls import HelperAnalysis, analyse_helper_rolls
from twistcore.detection.limb_flips import LimbFlipAnalysis, analyse_limbs
from twistcore.detection.noise_bursts import NoiseBurst, noise_burst_sentences, noise_bursts
from twistcore.detection.smoothed_spans import (
    SmoothedSpan,
    smoothed_span_sentences,
    smoothed_spans,
)
from twistcore.detection.soft_errors import unsearched_frames_sentences
from twistcore.errors import TwistError
from twistcore.formats.clip import Clip
from twistcore.skeleton.body import Body, Unexamined
from twistcore.skeleton.chain import Chain, chain_named, group_chains_by_person
from twistcore.skeleton.helper import Helper
from twistcore.skeleton.limb import Limb
from twistcore.skeleton.medians import median
from twistcore.skeleton.motion import HasMotion, Motion, forward_kinematics, motion_of
from twistcore.skeleton.notation import DistinctFrames, notes_on_coarse_motion_notation
from twistcore.skeleton.notes import (
    CONSTANT_OFFSET,
    FROZEN,
    NOISE,
    NOT_EXAMINED,
    RESTLESS_CLIP,
    SMOOTHED,
    UNEXAMINED,
    UNSEARCHED,
    Note,
)
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rig import AS_FOUND, Rig
from twistcore.skeleton.rotation import Array
from twistcore.skeleton.signals import TwistSignals, signals_of_chains
from twistcore.work.frozen import dataclass
from twistcore.work.progress import Tell, ignore_progress

SomeFault = TypeVar("SomeFault", NoiseBurst, SmoothedSpan)
# One value for all chains, or values keyed by the name of a chain or limb.
Tau = float | Mapping[str, float]
ALL_KINDS = frozenset(Kind)
REPAIRED = frozenset(kind for kind in Kind if kind.repairable)
_SOUGHT = tuple(kind for kind in Kind if kind.info.find)  # kinds with a finder function
# A person with at least this many lone jumps is restless: none of the person's intervals is
# corrected automatically.
RESTLESS, RESTLESS_A_MINUTE = 12, 24.0
BODY_STEP_DOUBT = "many joints jump at once where the interval begins or ends"
RESTLESS_DOUBT = "there are lone jumps throughout the clip, so every detection is uncertain"


class ClipAnalysis:
    """The analysis of a motion, independent of thresholds and of a reviewer's decisions.

    The object is returned by :func:`analyse`. It is immutable and thread-safe, and computes each
    result once, when first needed.

    Parameters
    ----------
    motion : Motion
        The motion to analyse.
    chains : sequence of Chain
        The chains and limbs to analyse.
    name : str
        Name of the clip, for messages.
    rig : Rig
        The user's changes to the skeleton's chains.
    chosen : bool
        True if the user chose some of the chains, False if all of them are analysed.
    people : sequence of str, optional
        Names of the people to whom the chains belong. None for all people.
    whole : ClipAnalysis, optional
        The analysis of all chains, if only some chains were chosen. Results are read from it.

    Examples
    --------
    >>> import twistcore as tc
    >>> analysis = tc.analyse(tc.read_clip("assets/walk_injected.bvh"))
    >>> analysis.chain("left arm"), len(analysis.limbs)
    (<Chain LeftArm: joints 18 → 19 → 20>, 4)
    >>> analysis.detect(kinds="limb flip")
    <Detection walk_injected.bvh: 0 intervals by consistency>
    """

    def __init__(
        self,
        motion: Motion,
        chains: Sequence[Chain],
        name: str = "motion",
        rig: Rig = AS_FOUND,
        *,
        chosen: bool = False,
        people: Sequence[str] | None = None,
        whole: ClipAnalysis | None = None,
    ) -> None:
        self.motion, self.name, self.rig = motion, name, rig
        self._whole = whole
        self.chosen, self._people = chosen, people
        self.chains = tuple(c for c in chains if not isinstance(c, Limb))
        self.limbs = tuple(c for c in chains if isinstance(c, Limb))
        self._by_method: dict[str, Analysis] = {}
        self._detectors: dict[str, Detector] = {}  # the detectors that computed `_by_method`
        # Detectors that failed, with the reasons.
        self._failed: dict[str, tuple[Detector, str]] = {}
        self._flips: LimbFlipAnalysis | None = None
        self._helpers: HelperAnalysis | None = None
        # Intervals keyed by kind and method ('' for the clip as captured), and results that finders
        # share.
        self._shown: dict[tuple[Kind, str], Mapping[str, tuple[Interval, ...]]] = {}
        self._shared: dict[str, dict[Any, Any]] = {}
        # Kinds from other packages whose search failed, with the reasons.
        self._failed_kinds: dict[Kind, str] = {}
        self._known: dict[str, tuple[Interval, ...]] = {}
        self._refiners: dict[str, Callable[[int, int], Motion] | None] = {}
        self._carried: dict[str, CarriedRolls] = {}  # keyed by method
        # Body steps without counter-twists, keyed by method.
        self._steps_left: dict[str, tuple[BodyStep, ...]] = {}
        self._rolls = CarriedRollTest(motion)
        self._left: WeakKeyDictionary[Interval, Interval] = WeakKeyDictionary()
        self._hinges: dict[tuple[str, bool], Hinges] = {}
        self._sure: dict[str, tuple[Interval, ...]] = {}
        # Maps an interval to its open copy, or to None if the interval does not become open.
        self._protected: WeakKeyDictionary[Interval, Interval | None] = WeakKeyDictionary()
        self._making = Lock()

    def __repr__(self) -> str:
        done = ", ".join(self._by_method) or "no detector run yet"
        return f"<ClipAnalysis {self.name}: {len(self.chains)} chains, {done}>"

    def with_rig(self, rig: Rig) -> ClipAnalysis:
        """Return an analysis with a different rig and the same choice of people and chains.

        Raises TwistError if the rig has none of the chosen chains.
        """
        if rig == self.rig:
            return self
        other = self._with_chains_of(rig)
        # Detectors that failed do not run again.
        (other._whole or other)._failed = dict((self._whole or self)._failed)
        for name in {"poses", "bursts"} & vars(self).keys():  # these do not depend on chains
            vars(other)[name] = getattr(self, name)
        if "signals" in vars(self):  # the signals of a chain do not depend on other chains
            stay = [c for c in other.chains if rig.own(c.name) == self.rig.own(c.name)]
            known = {c.name: self.signals[c.name] for c in stay if c.name in self.signals}
            new = [c for c in other.chains if c.name not in known]
            known |= signals_of_chains(self.motion, new)
            vars(other)["signals"] = {c.name: known[c.name] for c in other.chains}
        return other

    def _with_chains_of(self, rig: Rig) -> ClipAnalysis:
        """Return an analysis of a rig's chains, limited to chains that the user chose, if any."""
        every = rig.chains(self.motion)
        if self._people is not None:
            every = tuple(c for c in every if c.person in self._people)
        if not self.chosen:
            return ClipAnalysis(self.motion, every, self.name, rig, people=self._people)
        names = [c.name for c in self.chains_and_limbs]
        some = [c for c in every if c.name in names]
        if not some:
            raise TwistError(f"{self.name}: the rig has none of the chains {', '.join(names)}")
        whole = ClipAnalysis(self.motion, every, self.name, rig, people=self._people)
        return ClipAnalysis(
            self.motion, some, self.name, rig, chosen=True, people=self._people, whole=whole
        )

    @property
    def every_chain(self) -> tuple[Chain, ...]:
        """All chains that the detectors analyse, even if only some of them were chosen."""
        return self._whole.chains if self._whole else self.chains

    @property
    def chains_and_limbs(self) -> tuple[Chain, ...]:
        """All chains, followed by all limbs."""
        return *self.chains, *self.limbs

    def chain(self, name: str) -> Chain:
        """Return the chain or limb with the given name or label.

        Raises TwistError, which lists similar names, if there is none.
        """
        return chain_named(self.chains_and_limbs, name, self.name)

    @cached_property
    def signals(self) -> Mapping[str, TwistSignals]:
        """The twist signals of each chain, keyed by chain name."""
        return signals_of_chains(self.motion, self.chains)

    @cached_property
    def reliability(self) -> Mapping[str, float]:
        """The median reliability of the azimuth, 0…1, keyed by chain name.

        A low value means that the limb is often straight, so its azimuth θc is undefined.
        """
        return {k: median(s.azimuth_reliability) for k, s in self.signals.items()}

    @cached_property
    def poses(self) -> tuple[Array, Array]:
        """Global rotations, (frames, joints, 4), and positions, (frames, joints, 3)."""
        return forward_kinematics(self.motion)

    @cached_property
    def body(self) -> Body:
        """The limbs of the skeleton and the meanings of its joint names."""
        return self.rig.body(self.motion)

    @cached_property
    def not_examined(self) -> str:
        """The reason why the clip cannot be examined at all, as a clause, or ''."""
        return why_not_examined(self.motion, self.chains_and_limbs)

    @cached_property
    def unexamined(self) -> tuple[Unexamined, ...]:
        """The arms and legs that no chain examines. Empty if the user chose the chains."""
        if self.chosen:
            return ()
        every = unexamined_limbs(self.body, self.chains)
        return tuple(u for u in every if self._people is None or u.person in self._people)

    @property
    def people(self) -> tuple[str, ...]:
        """Names of the people in the skeleton. Empty if there is only one person."""
        return _people_of(self.motion)

    @cached_property
    def notes(self) -> tuple[Note, ...]:
        """Notes for the user, such as limbs that are not examined, noise bursts and held frames."""
        notes = [Note(UNEXAMINED, str(limb)) for limb in self.unexamined]
        if self.not_examined:
            notes = [Note(NOT_EXAMINED, f"The clip could not be examined: {self.not_examined}.")]
        else:
            if left_out := unexamined_segments_note(self.motion):
                notes.append(Note(UNEXAMINED, left_out))
            offsets = constant_offsets(self.motion, self._of_limbs)
            notes += (Note(CONSTANT_OFFSET, str(offset)) for offset in offsets)
            notes += self._fault_notes()
        borders = (Note("border", text) for text in ignored_frames_notes(self.motion))
        return (*notes, *notes_on_coarse_motion_notation(self.motion), *borders)

    def compared_with(
        self, reference: Clip | Motion | HasMotion, name: str = ""
    ) -> tuple[Note, ...]:
        """Compare the twists with another take. Return a note for each bone with a constant offset.

        Parameters
        ----------
        reference
            Another take of the same skeleton.
        name
            Name of the other take in the notes. By default, the clip's name.

        Raises
        ------
        ClipMismatchError
            If the skeletons differ.
        """
        name = name or (reference.name if isinstance(reference, Clip) else "the reference")
        offsets = constant_offsets_from_other_take(
            self.motion, self._of_limbs, motion_of(reference), name
        )
        if self.not_examined:
            return ()
        return tuple(Note(CONSTANT_OFFSET, str(offset)) for offset in offsets)

    def by(self, method: str = DEFAULT_METHOD, tell: Tell | None = None) -> Analysis:
        """Return a detector's analysis of the chains.

        `tell` is called with the progress, 0…1. Raises TwistError if the method is unknown or
        fails.
        """
        tell, detector = tell or ignore_progress, DETECTORS.named(method)
        if self._whole is not None:
            return self._whole.by(method, tell)
        if self._detectors.get(method) is detector:  # without waiting for other detectors
            return self._by_method[method]
        with self._making:
            if self._detectors.get(method) is not detector:
                self._forget(method)
                try:
                    self._by_method[method] = detector.analyse(self.motion, self._of_limbs, tell)
                except TwistError as error:
                    self._failed[method] = detector, str(error)
                    raise
                self._detectors[method] = detector
            return self._by_method[method]

    def usable(self, method: str) -> str:
        """Return `method`, or the default detector if `method` is missing or failed on this clip.

        No detector is run. A detector that has not run yet counts as usable.
        """
        name = DETECTORS.usable(method)
        return DEFAULT_METHOD if self.failure(name) else name

    def failure(self, method: str) -> str:
        """Return the error message of a detector that failed on this clip, or ''."""
        if self._whole is not None:
            return self._whole.failure(method)
        detector, why = self._failed.get(method, (None, ""))
        return why if detector is not None and detector is DETECTORS.get(method) else ""

    def give_up(self, method: str, why: str) -> None:
        """Mark a detector as failed on this clip. `why` is the error message."""
        if self._whole is not None:
            self._whole.give_up(method, why)
        elif method != DEFAULT_METHOD:
            self._forget(method)
            self._failed[method] = DETECTORS.named(method), why

    def _forget(self, method: str) -> None:
        """Discard all results of a detector."""
        for known in (
            self._by_method,
            self._detectors,
            self._known,
            self._refiners,
            self._carried,
            self._steps_left,
        ):
            known.pop(method, None)
        for shared in (self._shared, self._sure):
            shared.pop(method, None)
        for kind in _SOUGHT:
            self._shown.pop((kind, method), None)
        for key in [key for key in self._hinges if key[0] == method]:
            del self._hinges[key]

    def kept(self, method: str) -> Analysis | None:
        """Return a detector's analysis if it has already been computed, or None.

        This method never starts a detector or waits for one.
        """
        return self._whole.kept(method) if self._whole else self._by_method.get(method)

    def _fault_notes(self) -> Iterator[Note]:
        """Yield notes about noise bursts, frozen limbs and smoothed joints."""
        chains = self._of_limbs
        if not chains:  # the user chose only limbs
            joints = {j for limb in self.limbs for j in (limb.parent, limb.child)}
            within = [c for c in self.every_chain if c.parent in joints]
            chains = tuple(c for c in within if not isinstance(c, Helper))
        kinds = Kind.NOISE_BURST, Kind.FROZEN
        if chains == self._of_limbs:
            found = [self.shown(kind) for kind in kinds]
        else:
            found = [intervals_of_kind(k, replace(self.search(""), chosen=chains)) for k in kinds]
        bursts, frozen = (sum(map(len, own.values())) for own in found)
        every = self.every_chain if self._people is None else self.rig.chains(self.motion)
        limbs = [c for c in every if not isinstance(c, Helper | Limb)]
        outside = self._of_people(bursts_outside_chains(limbs, self.bursts))
        names = self.motion.skeleton.names
        yield from (Note(NOISE, text) for text in noise_burst_sentences(bursts, outside, names))
        if said := frozen_spans_sentence(frozen):
            yield Note(FROZEN, said)
        smoothed = self._of_people(smoothed_spans(self.motion))
        yield from (Note(SMOOTHED, text) for text in smoothed_span_sentences(smoothed, names))

    def _of_people(self, faults: Iterable[SomeFault]) -> list[SomeFault]:
        """Return the faults, excluding those at joints of people who were not chosen."""
        if self._people is None:
            return list(faults)
        others = {
            joint
            for person in find_people(self.motion.skeleton)
            if person.name not in self._people
            for joint in person.joints
        }
        return [fault for fault in faults if fault.joint not in others]

    @property
    def _of_limbs(self) -> tuple[Chain, ...]:
        """All chains except helper bones."""
        return tuple(c for c in self.chains if not isinstance(c, Helper))

    @property
    def helper_rolls(self) -> HelperAnalysis:
        """The analysis of the rolls of helper bones (twist bones)."""
        if self._whole is not None:
            return self._whole.helper_rolls
        if self._helpers is not None:  # without waiting for a detector
            return self._helpers
        with self._making:
            if self._helpers is None:
                helpers = [c for c in self.chains if isinstance(c, Helper)]
                self._helpers = analyse_helper_rolls(self.motion, helpers)
            return self._helpers

    @property
    def flips(self) -> LimbFlipAnalysis:
        """The analysis of limb flips."""
        if self._whole is not None:
            return self._whole.flips
        if self._flips is not None:  # without waiting for a detector
            return self._flips
        with self._making:
            if self._flips is None:
                self._flips = analyse_limbs(self.motion, self.limbs)
            return self._flips

    def shown(self, kind: Kind, method: str = DEFAULT_METHOD) -> Mapping[str, tuple[Interval, ...]]:
        """Return the intervals of a kind that is never corrected automatically.

        The result is keyed by chain name. Some kinds are searched for after all automatic
        corrections have been applied.
        """
        by = method if kind.info.corrected else ""
        if (kind, by) not in self._shown:
            try:
                found = intervals_of_kind(kind, self.search(by))
            except TwistError as error:
                if kind.built_in:
                    raise
                found = {chain.name: () for chain in self._of_limbs}
                self._failed_kinds.setdefault(kind, str(error))
            self._shown.setdefault((kind, by), found)
        return self._shown[kind, by]

    @property
    def failed_kinds(self) -> tuple[str, ...]:
        """Error messages of failed searches for kinds of error that other packages define."""
        return tuple(self._failed_kinds.values())

    def carried_along(self, twist: Interval) -> bool:
        """Return True if the child rolled with its parent during a detected counter-twist.

        If so, the interval may be part of a carried roll.
        """
        return self._rolls.is_carried(self.chain(twist.chain), twist)

    def carried_rolls(self, method: str = DEFAULT_METHOD) -> CarriedRolls:
        """Return the carried rolls that remain after a detector's automatic corrections."""
        if self._whole is not None:
            return self._whole.carried_rolls(method)
        if method not in self._carried:
            motion, chains = self.motion, self._of_limbs
            if not DETECTORS.named(method).info.has_confidence:
                chains = ()  # without confidence, it is unknown which counter-twists are corrected
            elif twists := [i for i in self._sure_by(method) if not self.carried_along(i)]:
                motion = refine(motion, chains, twists)
            reuse = motion is not self.motion
            self._carried[method] = analyse_rolls_carried_to_child(motion, chains, reuse=reuse)
        return self._carried[method]

    def jumps(self, method: str = DEFAULT_METHOD) -> Mapping[str, tuple[Interval, ...]]:
        """Return the lone jumps that remain after all automatic corrections.

        The result is keyed by chain name.
        """
        return (self._whole or self).shown(Kind.LONE_JUMP, method)

    def search(self, method: str) -> KindSearch:
        """Return the input for the functions that find each kind of error.

        `method` is the name of a detector, or '' for the clip as captured.
        """
        whole, chosen = self._whole or self, self._of_limbs
        shared, chains = whole._shared, whole._of_limbs
        captured = KindSearch(
            self.motion,
            chains,
            chosen,
            whole=not whole.chosen,
            _kept=shared.setdefault("", {}),
        )
        if not method:
            return captured
        return replace(
            captured,
            named=whole.chains_and_limbs,
            errors=partial(whole._errors, method),
            corrected=partial(whole._refined, method),
            without=partial(refiner, self.motion, whole.chains_and_limbs),
            captured=captured,
            _kept=shared.setdefault(method, {}),
        )

    def _errors(self, method: str) -> tuple[Interval, ...]:
        """Return all correctable intervals, detected with the automatic threshold τ."""
        if method not in self._known:
            detector = _ByName(self, method, REPAIRED, final=False)
            names = self._searched_names(REPAIRED)
            known = (i for n in names for i in detector.intervals(n, detector.automatic_tau(n)))
            self._known.setdefault(method, tuple(known))
        return self._known[method]

    def _applied(self, method: str) -> tuple[Interval, ...]:
        """Return the intervals of :meth:`_errors` that are corrected automatically."""
        return automatic_corrections(self._errors(method))

    def _refined(self, method: str) -> Callable[[int, int], Motion] | None:
        """Return a function that computes corrected frames, or None if nothing is corrected."""
        if method not in self._refiners:
            applied, chains = self._applied(method), self.chains_and_limbs
            made = refiner(self.motion, chains, applied) if applied else None
            self._refiners.setdefault(method, made)
        return self._refiners[method]

    @cached_property
    def bursts(self) -> tuple[NoiseBurst, ...]:
        """The noise bursts of all joints, sorted by start."""
        return self._whole.bursts if self._whole else noise_bursts(self.motion)

    def restless(self, method: str = DEFAULT_METHOD) -> tuple[str, ...]:
        """Return the people whose joints jump so often that no interval is certain.

        In a clip of one person, that person's name is ''. Jumps must be frequent both in the clip
        as captured and after the corrections. If they are rare in the clip as captured, no detector
        is run. Jumps within a noise burst are not counted.
        """
        if self._whole is not None:
            return self._whole.restless(method)
        known = self._shown.get((Kind.LONE_JUMP, method))
        if known is not None and not self._with_many(known):
            return ()
        if not (often := self._often_jumping):
            return ()
        return tuple(p for p in self._with_many(self.jumps(method)) if p in often)

    @cached_property
    def _often_jumping(self) -> tuple[str, ...]:
        return self._with_many(intervals_of_kind(Kind.LONE_JUMP, self.search("")))

    def _with_many(self, jumps: Mapping[str, Sequence[Interval]]) -> tuple[str, ...]:
        """Return the names of people with many jumps. `jumps` is keyed by chain name."""
        least = max(RESTLESS, RESTLESS_A_MINUTE * self.motion.frames / self.motion.fps / 60.0)
        counts = {
            person: sum(not self._in_burst(j) for c in own for j in jumps[c.name])
            for person, own in group_chains_by_person(self._of_limbs).items()
        }
        return tuple(person for person, count in counts.items() if count >= least)

    def _in_burst(self, jump: Interval) -> bool:
        names = self.motion.skeleton.names
        same = (b for b in self.bursts if names[b.joint] == jump.joint)
        return any(jump.start < b.stop and b.start < jump.stop for b in same)

    def left_open(self, interval: Interval) -> Interval:
        """Return a copy of a restless person's interval, marked as open.

        An open interval is not corrected automatically. An interval that is already open or cannot
        be corrected is returned unchanged. Repeated calls return the same object.
        """
        if interval.open or not interval.repairable:
            return interval
        if (kept := self._left.get(interval)) is None:
            explain = partial(_doubted, RESTLESS_DOUBT, interval.explain)
            kept = self._left[interval] = replace(interval, open=True, explain=explain)
        return kept

    def protected(self, interval: Interval, method: str = DEFAULT_METHOD) -> Interval:
        """Return the interval, or a copy marked as open if its correction might do harm.

        An interval becomes open if its correction would make a protected measure worse, or if its
        confidence is too low for its kind. A counter-twist at a sudden step of the whole body also
        becomes open, because the step alone may be the error. Intervals of a detector without
        confidence, such as the paper's, are returned unchanged. Repeated calls return the same
        object.
        """
        if self._whole is not None:
            return self._whole.protected(interval, method)
        if interval.open or not interval.automatic or interval.confidence is None:
            return interval
        if interval not in self._protected:
            if interval.kind == Kind.COUNTER_TWIST and self._at_body_step(interval, method):
                explain = partial(_doubted, BODY_STEP_DOUBT, interval.explain)
            elif interval.confidence < interval.kind.info.sure:
                explain = partial(_doubted, interval.kind.info.doubt, interval.explain)
            elif worse := tuple(m for m in self._measures(interval, method) if m.worse):
                explain = partial(_made_worse, interval.explain, worse)
            else:
                explain = None
            left = replace(interval, open=True, explain=explain) if explain else None
            self._protected.setdefault(interval, left)
        return self._protected[interval] or interval

    def _at_body_step(self, interval: Interval, method: str) -> bool:
        """Return True if the whole body jumps (a body step) at an edge of the interval.

        Counter-twists of many chains that begin in the same frame look like a body step. Therefore
        the step must remain after all counter-twists are removed.
        """
        person = self.chain(interval.chain).person
        if not is_at_body_step(body_steps(self.motion), interval, person):
            return False
        if method not in self._steps_left:
            untwisted = refine(self.motion, self._of_limbs, self._twists_by(method))
            self._steps_left[method] = body_steps(untwisted)
        return is_at_body_step(self._steps_left[method], interval, person)

    def _measures(self, interval: Interval, method: str) -> tuple[ProtectedMeasure, ...]:
        """Measure how the correction of an interval affects its limb and neighbouring chains."""
        if interval.kind != Kind.COUNTER_TWIST:  # other kinds need no detector of chains
            every = self.chains_and_limbs
            return protected_measures(self.motion, every, interval, self._plain_hinges)
        others, kept = self._corrected_with(interval, method), _kept(self.by(method))
        if kept is None or kept.even:
            hinges = self._hinges_by(method, None)
            measured = protected_measures(self.motion, self._of_limbs, interval, hinges, others)
            if kept is None or not any(m.worse for m in measured):
                return measured
        # Interpolated and held frames were not captured, so errors that appear only in them are
        # ignored.
        own, *others = (restrict_interval_to_frames(i, kept.first) for i in (interval, *others))
        needed = {i.chain for i in (own, *others)}
        chains = [c.at(kept.first) for c in self._of_limbs if c.name in needed]
        hinges = self._hinges_by(method, kept)
        return protected_measures(kept.motion, chains, own, hinges, others)

    @cached_property
    def _plain_hinges(self) -> Hinges:
        """The hinge joints of the clip, measured in all captured frames."""
        return Hinges(self.motion)

    def _corrected_with(self, interval: Interval, method: str) -> list[Interval]:
        """Return corrected counter-twists in chains that share a joint with an interval's chain.

        Only automatic corrections are included, and the interval itself is excluded. If it is not
        corrected automatically, for example because τ was changed, all counter-twists in its chain
        are excluded, because they may be the same error.
        """
        own = self.chain(interval.chain)
        joints = {own.parent, own.child}
        near = {c.name for c in self._of_limbs if not joints.isdisjoint((c.parent, c.child))}
        sure = self._sure_by(method)
        if all(i is not interval for i in sure):
            near.discard(own.name)
        return [i for i in sure if i.chain in near and i is not interval]

    def _sure_by(self, method: str) -> tuple[Interval, ...]:
        """Return the counter-twists at the automatic τ that are corrected automatically."""
        if method not in self._sure:
            self._sure[method] = automatic_corrections(self._twists_by(method))
        return self._sure[method]

    def _twists_by(self, method: str) -> list[Interval]:
        """Return all counter-twists that are detected with the automatic threshold τ."""
        known = self.by(method)
        names = [c.name for c in self._of_limbs]
        return [i for n in names for i in known.intervals(n, known.automatic_tau(n))]

    def _hinges_by(self, method: str, kept: DistinctFrames | None) -> Hinges:
        """Return the hinge joints of the clip, measured in the frames outside counter-twists.

        If `kept` is not None, only these distinct frames of the clip are used.
        """
        key = method, kept is None
        if key not in self._hinges:
            finds, motion = self._twists_by(method), self.motion
            if kept is not None:
                motion, finds = (
                    kept.motion,
                    [restrict_interval_to_frames(i, kept.first) for i in finds],
                )
            known = getattr(self.by(method), "witnesses", {})
            self._hinges[key] = Hinges(motion, finds, known)
        return self._hinges[key]

    def detector(
        self, method: str = DEFAULT_METHOD, kinds: Collection[Kind] | None = None
    ) -> Analysis:
        """Return a combined analysis of chains and limbs, limited to the given kinds of error.

        The analysis combines :meth:`by` and :meth:`shown` for chains with :attr:`flips` for limbs.
        Results are computed when first needed. By default, all kinds are included. Raises
        TwistError for an unknown method.
        """
        DETECTORS.named(method)
        return _ByName(self, method, ALL_KINDS if kinds is None else frozenset(kinds))

    def detect(
        self,
        method: str | Detector = DEFAULT_METHOD,
        *,
        kinds: Collection[Kind | str] | str | None = None,
        tau_radians: Tau | None = None,
        tau_degrees: Tau | None = None,
        tell: Tell | None = None,
    ) -> Detection:
        """Find intervals with errors of the given kinds, first in chains and then in limbs.

        Parameters
        ----------
        method
            The name of a detector, or a detector to register.
        kinds
            The kinds to search for. By default, all.
        tau_radians, tau_degrees
            Threshold τ for all chains, or keyed by the name of a chain or limb. By default, τ is
            automatic. A single number does not apply to limbs and helpers, whose τ is a different
            quantity. Kinds that cannot be corrected have no τ.
        tell
            Called with the progress, 0…1.

        Returns
        -------
        Detection
            The intervals.

        Raises
        ------
        TwistError
            If a kind, method or name is unknown, or if τ is given in both units.
        """
        wanted, method = _kinds(kinds), _name_of(method)
        detector = self.detector(method, wanted)
        if tell is not None:
            self.by(method, tell)
        given = self._given(tau_radians, tau_degrees)
        names = self._searched_names(wanted)
        tau = {n: given[n] if n in given else detector.automatic_tau(n) for n in names}
        found = [i for name, t in tau.items() for i in detector.intervals(name, t)]
        return Detection(self, method, MappingProxyType(tau), tuple(found))

    def tau_of(
        self, for_all: float | None, by_name: Mapping[str, float] = MappingProxyType({})
    ) -> dict[str, float]:
        """Return the thresholds τ in radians, keyed by the name of the chain or limb.

        `for_all` is τ for all chains except limbs and helpers. `by_name` contains the values of a
        profile, which take precedence. Names that the clip does not have are ignored.
        """
        names = {c.name for c in self.chains_and_limbs}
        return self._given(for_all, None) | {k: t for k, t in by_name.items() if k in names}

    def _searched_names(self, kinds: Collection[str]) -> tuple[str, ...]:
        """Return the names of the chains and limbs in which any of the given kinds can be found."""
        chains = self.chains if set(kinds) - {Kind.LIMB_FLIP} else ()
        return tuple(c.name for c in (*chains, *(self.limbs if Kind.LIMB_FLIP in kinds else ())))

    def _given(self, radians: Tau | None, degrees: Tau | None) -> dict[str, float]:
        """Return the given thresholds in radians, keyed by the name of the chain or limb.

        Raises TwistError if τ is given in both units or for an unknown chain.
        """
        if degrees is not None:
            if radians is not None:
                raise TwistError("expected τ in degrees or in radians, found both")
            return {name: math.radians(t) for name, t in self._given(degrees, None).items()}
        if isinstance(radians, Mapping):
            return {self.chain(name).name: float(t) for name, t in radians.items()}
        return {} if radians is None else {c.name: float(radians) for c in self._of_limbs}


@dataclass(frozen=True, eq=False)
class _ByName:
    """The detectors for chains, helpers and limb flips, combined into one analysis.

    Restless people (those with many lone jumps) are known only after all other kinds have been
    searched for. During that search, `final` is False, and no interval is marked as open because of
    a restless person.
    """

    clip: ClipAnalysis
    method: str
    kinds: frozenset[Kind]
    final: bool = True

    def automatic_tau(self, chain: str) -> float:
        return self._of(chain).automatic_tau(chain)

    def strength(self, chain: str) -> Array:
        return self._of(chain).strength(chain)

    def intervals(self, chain: str, tau: float) -> tuple[Interval, ...]:
        named = self.clip.chain(chain)
        is_limb = isinstance(named, Limb)
        found: list[Interval] = []
        kind = Kind.LIMB_FLIP if is_limb else Kind.COUNTER_TWIST
        if isinstance(named, Helper):
            kind = Kind.HELPER_ROLL
        if kind in self.kinds:
            found += self._of(chain).intervals(chain, tau)
        if not isinstance(named, Limb | Helper) and Kind.CARRIED_ROLL in self.kinds:
            found = self._with_carried(chain, tau, found)
        if found and isinstance(named, Limb) and Kind.COUNTER_TWIST in self.kinds:
            found = self._without_side_effects(named, found)
        found = [self.clip.protected(i, self.method) for i in found]
        if not isinstance(named, Limb | Helper):
            for sought in filter(self.kinds.__contains__, _SOUGHT):  # in the order of the kinds
                found += self.clip.shown(sought, self.method)[chain]
        unsure = self.final and any(not i.open for i in found)
        if unsure and named.person in self.clip.restless(self.method):
            found = [self.clip.left_open(i) for i in found]
        return tuple(sorted(found, key=lambda i: (i.start, i.stop)))

    def _with_carried(self, chain: str, tau: float, found: list[Interval]) -> list[Interval]:
        """Add a chain's carried rolls, and remove the counter-twists that are part of a roll.

        In a bent limb, a carried roll looks like a counter-twist. In a nearly straight limb, only a
        part of it does.
        """
        rolls = self.clip.carried_rolls(self.method).intervals(chain, tau)
        sure = [r for r in rolls if not r.open]
        left = (
            i
            for i in found
            if not any(_overlap(i, r) for r in sure) or not (i.open or self.clip.carried_along(i))
        )
        return [*left, *rolls]

    def _without_side_effects(self, limb: Limb, flips: Sequence[Interval]) -> list[Interval]:
        """Return the flips, excluding side effects of twist errors in the limb's first joint.

        If a child did not fully compensate its parent's twist error, the rest of the limb rotates
        by the remaining angle. This is one error, not two.
        """
        known = self.clip.by(self.method)
        twists = [
            i
            for chain in self.clip.every_chain
            if chain.parent == limb.parent and not isinstance(chain, Helper)
            for i in known.intervals(chain.name, known.automatic_tau(chain.name))
            if i.followed < 1.0 and not i.open
        ]
        return [f for f in flips if not any(_same_frames(f, i) for i in twists)]

    def _of(self, name: str) -> Analysis:
        chain = self.clip.chain(name)
        if isinstance(chain, Helper):
            return self.clip.helper_rolls
        return self.clip.flips if isinstance(chain, Limb) else self.clip.by(self.method)


def _doubted(doubt: str, explain: Callable[[], dict[str, Any]] | None) -> dict[str, Any]:
    """Return an interval's evidence, with `doubt` as the first reason for doubt.

    `explain` returns the evidence to extend, or is None if there is no evidence.
    """
    evidence = explain() if explain else {}
    return {**evidence, "doubts": [doubt, *evidence.get("doubts", ())]}


def _kept(analysis: Analysis) -> DistinctFrames | None:
    """Return the distinct frames of a clip with repeated or interpolated frames, or None."""
    kept: DistinctFrames | None = getattr(analysis, "kept", None)
    return kept


def _made_worse(
    explain: Callable[[], dict[str, Any]] | None, worse: Sequence[ProtectedMeasure]
) -> dict[str, Any]:
    """Return an interval's evidence, extended by the measures that its correction makes worse.

    `explain` returns the evidence to extend, or is None if there is no evidence.
    """
    evidence = explain() if explain else {}
    doubts = [m.doubt for m in worse]
    doubts += [d for d in evidence.get("doubts", ()) if d not in doubts]
    return {**evidence, "doubts": doubts, "worse": [m.name for m in worse]}


def _overlap(a: Interval, b: Interval) -> bool:
    return a.start < b.stop and b.start < a.stop


def _same_frames(a: Interval, b: Interval) -> bool:
    return abs(a.start - b.start) <= 1 and abs(a.stop - b.stop) <= 1


@dataclass(frozen=True, eq=False)
class Detection:
    """The intervals found in a clip, sorted by chain and start, limbs last.

    A detection is a sequence of :class:`Interval`. It can also be indexed by a name:
    ``found["LeftArm"]`` is the detection for only that chain or limb.

    Parameters
    ----------
    analysis : ClipAnalysis
        The analysis that was searched.
    method : str
        Name of the detector for chains.
    tau : mapping of str to float
        Threshold τ in radians, keyed by the name of each chain and limb that was searched.
    intervals : tuple of Interval
        The intervals that were found.

    Examples
    --------
    >>> import twistcore as tc
    >>> found = tc.detect(tc.read_clip("assets/walk_injected.bvh"))
    >>> len(found), len(found["LeftForeArm"]), found[-1].start
    (8, 3, 241)
    >>> found.to_rows()[0]["kind"]
    'counter-twist'
    >>> found.refined()
    <Motion: 344 frames at 120 fps, 31 joints>
    """

    analysis: ClipAnalysis
    method: str
    tau: Mapping[str, float]
    intervals: tuple[Interval, ...]

    def __repr__(self) -> str:
        found = f"{len(self)} interval{'' if len(self) == 1 else 's'}"
        return f"<Detection {self.analysis.name}: {found} by {self.method}>"

    @property
    def chains(self) -> tuple[Chain, ...]:
        """The chains that were searched."""
        return tuple(c for c in self.analysis.chains if c.name in self.tau)

    @property
    def limbs(self) -> tuple[Limb, ...]:
        """The limbs that were searched for flips."""
        return tuple(c for c in self.analysis.limbs if c.name in self.tau)

    @property
    def chains_and_limbs(self) -> tuple[Chain, ...]:
        """All chains and limbs that were searched."""
        return *self.chains, *self.limbs

    @property
    def not_examined(self) -> str:
        """The reason why the clip could not be examined at all, as a clause, or ''."""
        return "" if self.intervals else self.analysis.not_examined

    @property
    def notes(self) -> tuple[Note, ...]:
        """Notes about the clip and the search.

        If any interval was found, the note that the clip could not be examined is omitted.
        """
        notes = self.analysis.notes
        if self.intervals:
            notes = tuple(n for n in notes if n.kind != NOT_EXAMINED)
        left: Mapping[str, Sequence[tuple[int, int]]] = getattr(
            self.analysis.kept(self.method), "left", {}
        )
        looked_at = {name: spans for name, spans in left.items() if name in self.tau}
        notes = (
            *notes,
            *(Note(UNSEARCHED, said) for said in unsearched_frames_sentences(looked_at)),
        )
        notes = (*notes, *(Note(UNSEARCHED, f"{why}.") for why in self.analysis.failed_kinds))
        return (*notes, *(Note(RESTLESS_CLIP, said) for said in self._restless_sentences()))

    def _restless_sentences(self) -> Iterator[str]:
        """Yield a sentence for each restless person whose chains or limbs were searched."""
        looked_at = {c.person for c in self.chains_and_limbs}
        for person in self.analysis.restless(self.method):
            if person not in looked_at:
                continue
            own = group_chains_by_person(self.analysis.every_chain)[person]
            jumps = self.analysis.jumps(self.method)
            count = sum(len(jumps.get(c.name, ())) for c in own)
            if person:
                yield (
                    f"{person} has {count} lone jumps, so every detection for this person "
                    "is uncertain and none is corrected automatically."
                )
            else:
                yield (
                    f"The clip has {count} lone jumps, so every detection is uncertain and "
                    "nothing is corrected automatically."
                )

    def __len__(self) -> int:
        return len(self.intervals)

    def __iter__(self) -> Iterator[Interval]:
        return iter(self.intervals)

    @overload
    def __getitem__(self, at: int) -> Interval: ...

    @overload
    def __getitem__(self, at: slice) -> tuple[Interval, ...]: ...

    @overload
    def __getitem__(self, at: str) -> Detection: ...

    def __getitem__(self, at: int | slice | str) -> Interval | tuple[Interval, ...] | Detection:
        if not isinstance(at, str):
            return self.intervals[at]
        name = chain_named(self.chains_and_limbs, at, self.analysis.name).name
        own = tuple(i for i in self.intervals if i.chain == name)
        return replace(self, tau=MappingProxyType({name: self.tau[name]}), intervals=own)

    def to_correct(
        self,
        motion: Motion | None = None,
        at_least: float | None = None,
        *,
        include_open: bool = False,
    ) -> tuple[tuple[Chain, ...], tuple[Interval, ...]]:
        """Return all chains and limbs, and the intervals that are corrected automatically.

        `at_least` and `include_open` are the same as in :meth:`refined`. `motion` is ignored.
        """
        del motion  # not needed, because the analysis already has the chains
        sure = automatic_corrections(self, at_least, include_open=include_open)
        return self.chains_and_limbs, sure

    def refined(self, at_least: float | None = None, *, include_open: bool = False) -> Motion:
        """Return the motion after all automatic corrections.

        Parameters
        ----------
        at_least : float, optional
            Minimum confidence of an interval to correct, 0…1. By default, 0.5.
        include_open : bool
            True to correct open intervals, too.

        Returns
        -------
        Motion
            The corrected motion.

        Examples
        --------
        >>> import twistcore as tc
        >>> found = tc.detect(tc.read_clip("assets/walk_injected.bvh"))
        >>> len(tc.detect(found.refined()))
        0
        """
        return refine(
            self.analysis.motion,
            *self.to_correct(None, at_least, include_open=include_open),
        )

    def to_rows(self, *, explain: bool = False) -> list[dict[str, Any]]:
        """Return one dict per interval, with the fields of `twistcore detect --json`.

        Parameters
        ----------
        explain : bool
            True to add `residual_deg` and `evidence`, like the option `--explain`.

        Returns
        -------
        list of dict
            Values are numbers, strings, lists or None. Frames count from 0, `stop` is exclusive,
            and angles are in degrees.

        Examples
        --------
        >>> import twistcore as tc
        >>> found = tc.detect(tc.read_clip("assets/walk_injected.bvh"))
        >>> row = found.to_rows()[0]
        >>> row["chain"], row["start"], row["stop"], round(row["delta_deg"])
        ('LeftForeArm', 122, 138, -21)
        """
        chains = {chain.name: chain for chain in self.chains_and_limbs}
        names = self.analysis.motion.skeleton.names
        return [_row(i, chains[i.chain], names, explain=explain) for i in self]

    def to_dataframe(self, *, explain: bool = False) -> Any:
        """Return :meth:`to_rows` as a pandas DataFrame.

        Raises TwistError if pandas is not installed.
        """
        try:
            pandas = import_module("pandas")  # imported here: it is optional and slow to load
        except ImportError:
            raise TwistError(
                "to_dataframe needs pandas: install it with pip install pandas"
            ) from None
        rows = self.to_rows(explain=explain)
        return pandas.DataFrame(rows, columns=None if rows else _COLUMNS)


def analyse(
    clip: Clip | Motion | HasMotion,
    chains: Sequence[Chain | str] | Chain | str | None = None,
    rig: Rig = AS_FOUND,
    people: Sequence[str] | str | None = None,
) -> ClipAnalysis:
    """Find a clip's chains, and return an analysis that computes its results when first needed.

    Parameters
    ----------
    clip : Clip or Motion
        The clip to analyse.
    chains : str, Chain or sequence of these, optional
        The chains and limbs to analyse, as objects or by a name or label that `twistcore info`
        lists. By default, all. Case matters only if two names differ only in case. A chain's name
        includes the limb that begins with it, while a limb's name means only that limb.
    rig : Rig, optional
        Changes to the chains of the skeleton. By default, none.
    people : str or sequence of str, optional
        Names of the people whose chains are analysed. By default, all people.

    Returns
    -------
    ClipAnalysis
        The analysis, which caches its results.

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion.
    TwistError
        If a chain, limb or person does not exist.

    See Also
    --------
    detect : Find the intervals in one step.

    Examples
    --------
    >>> import twistcore as tc
    >>> analysis = tc.analyse(tc.read_clip("assets/walk_injected.bvh"))
    >>> analysis
    <ClipAnalysis walk_injected.bvh: 10 chains, no detector run yet>
    >>> len(analysis.detect()), len(analysis.detect("paper", tau_degrees=20.0))
    (8, 5)
    """
    motion = motion_of(clip)
    name = where = "motion"
    if isinstance(clip, Clip):
        name, where = clip.name, str(clip.path)
    chains = (chains,) if isinstance(chains, Chain | str) else chains
    people = (people,) if isinstance(people, str) else people
    given = [c for c in chains or () if isinstance(c, Chain)]
    if chains is not None and len(given) == len(chains):
        return ClipAnalysis(motion, given, name, rig, chosen=True)
    every = rig.chains(motion)
    if people is not None:
        _check_people(motion, people, where)
        every = tuple(c for c in every if c.person in people)
    if chains is None:
        return ClipAnalysis(motion, every, name, rig, people=people)
    names = (c.name if isinstance(c, Chain) else c for c in chains)
    wanted = {chain_named(every, name, where).name for name in names}
    first = {c.name: {c.name, motion.skeleton.names[c.parent]} for c in every}
    some = [c for c in every if not wanted.isdisjoint(first[c.name])]
    whole = ClipAnalysis(motion, every, name, rig, people=people)
    return ClipAnalysis(motion, some, name, rig, chosen=True, people=people, whole=whole)


def detect(
    clip: Clip | Motion | HasMotion,
    chains: Sequence[Chain | str] | Chain | str | None = None,
    method: str | Detector = DEFAULT_METHOD,
    *,
    kinds: Collection[Kind | str] | str | None = None,
    tau_degrees: Tau | None = None,
    tau_radians: Tau | None = None,
    tell: Tell | None = None,
) -> Detection:
    """Find the intervals in which a joint's rotation is wrong.

    Parameters
    ----------
    clip : Clip or Motion
        The clip to search.
    chains : str, Chain or sequence of these, optional
        The chains and limbs to search, as in :func:`analyse`. By default, all.
    method : str or Detector
        The detector for chains: 'consistency', 'paper', the name of another detector, or a detector
        to register.
    kinds : Kind, str or collection of these, optional
        The kinds of error to search for. By default, all. ``"counter_twist"`` and
        ``"Counter-Twist"`` mean the same.
    tau_degrees, tau_radians : float or mapping of str to float, optional
        Threshold τ for all chains, or keyed by the name of a chain or limb, in degrees or in
        radians. Chains without a value have an automatic τ.
    tell : callable, optional
        Called repeatedly with the progress, 0…1.

    Returns
    -------
    Detection
        The intervals, sorted by chain and start, limbs last.

    Raises
    ------
    TypeError
        If `clip` is neither a clip nor a motion.
    TwistError
        If a chain, kind or method does not exist, or τ is given in both units.

    See Also
    --------
    analyse : Analyse a clip once for several searches.
    refine : Remove the errors that were found.

    Examples
    --------
    >>> import twistcore as tc
    >>> clip = tc.read_clip("assets/walk_injected.bvh")
    >>> found = tc.detect(clip)
    >>> found
    <Detection walk_injected.bvh: 8 intervals by consistency>
    >>> found[1]
    <Interval LeftForeArm 206–213: -109.1°, confidence 0.99>
    >>> len(tc.detect(clip, "left forearm", kinds="counter_twist"))
    3
    """
    found = analyse(clip, chains)
    return found.detect(
        method, kinds=kinds, tau_degrees=tau_degrees, tau_radians=tau_radians, tell=tell
    )


# The fields of `detect --json`, in order.
_COLUMNS = ("chain", "parent", "child", "start", "stop", "delta_deg", "confidence", "open", "kind")


def _row(
    interval: Interval, chain: Chain, names: Sequence[str], *, explain: bool
) -> dict[str, Any]:
    """Return an interval as a row of `detect --json`. `names` are the names of all joints."""
    parent = names[chain.parent]
    values = (
        *(parent, parent, names[chain.child], interval.start, interval.stop),
        *(math.degrees(interval.delta), interval.confidence, interval.open, interval.kind.value),
    )
    row: dict[str, Any] = dict(zip(_COLUMNS, values, strict=True))
    if chain.person:
        row["person"] = chain.person
    if isinstance(chain, Limb):
        row |= {"limb": chain.name, "end": names[chain.end], "carried": interval.carried}
    if not interval.repairable:
        row |= interval.evidence or {}
    if explain:
        row["residual_deg"] = math.degrees(interval.residual)
        row["evidence"] = interval.evidence
    return row


def _kinds(kinds: Collection[Kind | str] | str | None) -> frozenset[Kind]:
    """Return the kinds with the given names, or all kinds if `kinds` is None.

    Raises TwistError if a name is unknown.
    """
    if kinds is None:
        return ALL_KINDS
    wanted = []
    for word in (kinds,) if isinstance(kinds, str) else kinds:
        if not (word and (kind := Kind(word)).known):
            raise TwistError(f"{word!r} is not a kind of error; expected one of {', '.join(Kind)}")
        wanted.append(kind)
    return frozenset(wanted)


def _people_of(motion: Motion) -> tuple[str, ...]:
    return tuple(person.name for person in find_people(motion.skeleton) if person.name)


def _check_people(motion: Motion, people: Sequence[str], where: str) -> None:
    known = _people_of(motion)
    if unknown := [name for name in people if name not in known]:
        there = f"expected one of {', '.join(known)}" if known else "the clip has only one person"
        raise TwistError(f"{where}: there is no person {unknown[0]!r}; {there}")


def _name_of(method: str | Detector) -> str:
    return method if isinstance(method, str) else DETECTORS.register(method).info.name
