"""What a journal's lines say, what of them is replayed, and what becomes of its file."""

import json
import os
from contextlib import closing
from dataclasses import fields, replace

import numpy as np
import pytest

from tests.messages import refused
from tests.twistcore.small_review import (
    ARM,
    BULK,
    CLIP,
    FOREARM,
    LIMB,
    SEEN,
    SHOULDER,
    TAU,
    TRACKING,
    flip,
    state,
    twist,
)
from twistcore.detection.interval_json import interval_to_json
from twistcore.errors import FormatError, TwistError
from twistcore.files.lock import is_file_locked
from twistcore.quamo.tracking_settings import tracking_to_json
from twistcore.review import Decision, Journal, replay_journal
from twistcore.review.commands import (
    Annotate,
    CarryOver,
    ChangeChains,
    Command,
    Edit,
    Insert,
    Redetect,
    Remove,
    Settle,
    Track,
)
from twistcore.review.decisions import Decide, Sign
from twistcore.review.journal import (
    REDO,
    UNDO,
    command_from_json,
    review_command_to_json,
    session_journal_entry,
)
from twistcore.review.left_out import LeaveOut
from twistcore.review.session import judged_to_json, session_bytes, session_document
from twistcore.skeleton.rig import AS_FOUND, OwnChain, Rig

BEGUN = state(BULK, SEEN)
RIG = Rig((OwnChain(("hip", "chest", SHOULDER)),), ("RightClavicle",))
OTHER = replace(CLIP, data=CLIP.data + b"\n")
OTHERWISE = replace(TRACKING, place=True)
EVERY = {
    Decide((1, 2), Decision.REJECTED, "Ada", "then", in_bulk=True): {
        "do": "Decide", "ids": [1, 2], "decision": "rejected", "reviewer": "Ada",
        "decided_at": "then", "in_bulk": True,
    },
    Decide((1, 2), Decision.REJECTED, "Ada", "then", reason="noise"): {
        "do": "Decide", "ids": [1, 2], "decision": "rejected", "reviewer": "Ada",
        "decided_at": "then", "in_bulk": False, "reason": "noise",
    },
    Sign((2,), "Ada"): {"do": "Sign", "ids": [2], "reviewer": "Ada"},
    Edit(2, twist(FOREARM), drag=7): {
        "do": "Edit", "id": 2, "interval": interval_to_json(twist(FOREARM)), "drag": 7,
    },
    Annotate(1, "seen", "noise"): {"do": "Annotate", "id": 1, "note": "seen", "reason": "noise"},
    Insert(flip()): {"do": "Insert", "interval": interval_to_json(flip())},
    Remove(1): {"do": "Remove", "id": 1},
    Redetect({ARM: np.radians(2.5)}, (twist(),), "consistency", 3, "τ of arm"): {
        "do": "Redetect", "tau_deg": {ARM: 2.5}, "found": [interval_to_json(twist())],
        "method": "consistency", "drag": 3, "what": "τ of arm",
    },
    ChangeChains(RIG, {ARM: np.radians(2.5)}, (ARM,), (twist(),), "Two more"): {
        "do": "ChangeChains",
        "rig": {"add": [{"joints": ["hip", "chest", SHOULDER]}], "remove": ["RightClavicle"]},
        "tau_deg": {ARM: 2.5}, "again": [ARM], "found": [interval_to_json(twist())],
        "what": "Two more",
    },
    ChangeChains(RIG, {ARM: np.radians(2.5)}, (), (), moved={FOREARM: ARM}): {
        "do": "ChangeFirstChain",
        "rig": {"add": [{"joints": ["hip", "chest", SHOULDER]}], "remove": ["RightClavicle"]},
        "tau_deg": {ARM: 2.5}, "again": [], "found": [], "what": "", "moved": {FOREARM: ARM},
    },
    CarryOver((SEEN,), same_clip=True): {
        "do": "CarryOver", "earlier": [judged_to_json(SEEN)], "same_clip": True,
    },
    Settle((SEEN,)): {"do": "Settle", "earlier": [judged_to_json(SEEN)]},
    Track(TRACKING): {"do": "Track", "tracking": tracking_to_json(TRACKING)},
    Track(OTHERWISE): {"do": "TrackBothWays", "tracking": tracking_to_json(OTHERWISE)},
    Track(None): {"do": "Track", "tracking": None},
    LeaveOut(((0, 1), (4, 6))): {"do": "LeaveOut", "spans": [[0, 1], [4, 6]]},
}  # fmt: skip


def test_a_program_that_does_not_know_the_reason_reads_the_rejection():
    command = Decide((1, 2), Decision.REJECTED, "Ada", "then", reason="noise")
    line = review_command_to_json(command)
    first = {"do", "ids", "decision", "reviewer", "decided_at", "in_bulk"}  # the keys it knows
    assert first < line.keys()
    plain = command_from_json({key: line[key] for key in first})
    assert plain == Decide((1, 2), Decision.REJECTED, "Ada", "then")


def test_there_is_a_line_for_every_command():
    assert {type(c) for c in EVERY} == set(Command.__subclasses__())


@pytest.mark.parametrize(("command", "line"), EVERY.items(), ids=lambda x: type(x).__name__)
def test_a_command_is_its_verb_and_its_fields_and_comes_back(command, line):
    found = json.loads(json.dumps(review_command_to_json(command)))
    assert found == line
    assert list(found) == list(line)
    back = command_from_json(found)
    assert type(back) is type(command)
    assert json.loads(json.dumps(review_command_to_json(back))) == line
    for name in ("ids", "spans", "again", "decision", "rig", "tracking"):  # as they were, not lists
        assert getattr(back, name, None) == getattr(command, name, None)
        assert type(getattr(back, name, None)) is type(getattr(command, name, None))
    for field in fields(command):
        key = {"tau": "tau_deg"}.get(field.name, field.name)
        without = {k: v for k, v in line.items() if k != key}
        late = ["same_clip", "in_bulk", "what"]
        late += {"Decide": ["reason"], "ChangeChains": ["moved"]}.get(line["do"], [])
        if key in late:  # the first journals did not have these
            assert getattr(command_from_json(without), key) in (False, "", {})
        else:
            with refused(FormatError, f" {key}"):
                command_from_json(without)


@pytest.mark.parametrize("line", EVERY.values(), ids=lambda x: x["do"])
def test_a_damaged_field_is_told_by_its_name(line):
    for key in line.keys() - {"do"}:
        name = {"spans": "left_out", "interval": "document"}.get(key, key)
        with refused(FormatError, f" {name}"):
            command_from_json(line | {key: 3.5})


def test_a_damaged_member_of_a_list_is_told_by_its_place():
    for line, key, damage, facts in (
        ("Decide", "ids", [1, "2"], ("ids", "2: ")),
        ("Redetect", "found", [3], ("found", "1: ")),
        ("CarryOver", "earlier", [3], ("earlier", "1: ")),
        ("ChangeChains", "again", [3], ("again",)),
    ):
        whole = next(of for of in EVERY.values() if of["do"] == line)
        with refused(FormatError, *facts):
            command_from_json(whole | {key: damage})
    for damage in (3, {}, {"do": "Reconsider"}, {"do": None}, {"ids": [1]}):
        with pytest.raises(FormatError, match=r"\bdo\b|an object"):
            command_from_json(damage)


# -- replaying -------------------------------------------------------------------------------------


@pytest.fixture
def path(tmp_path):
    return tmp_path / "walk.twist.journal"


def begin(path, *entries, of=BEGUN, steps=0):
    """A journal with these commands or entries, closed."""
    with closing(Journal(path, CLIP, of, steps)) as journal:
        for entry in entries:
            journal.do(entry) if isinstance(entry, Command) else journal.append(entry)
    return path


def test_every_line_of_a_journal(path):
    decide = Decide((2,), Decision.ACCEPTED)
    begin(path, decide, UNDO, REDO, session_journal_entry(CLIP, BEGUN), steps=4)
    session = json.loads(session_bytes(CLIP, BEGUN))
    head, *lines = map(json.loads, path.read_bytes().splitlines())
    assert head == {"schema": "twistcore.journal/1", "steps": 4, "session": session}
    assert lines == [
        review_command_to_json(decide),
        {"undo": True},
        {"redo": True},
        {"session": session},
    ]
    back = replay_journal(path, CLIP)
    assert (back.path, back.session.sha256) == (path, CLIP.sha256)
    assert (back.entries, back.steps, back.damaged) == (4, 8, 0)
    assert back.size == path.stat().st_size
    assert replay_journal(begin(path.with_name("other"))).steps == 0


@pytest.mark.parametrize("clip", [None, CLIP, OTHER])
def test_commands_are_replayed_in_their_order(path, clip):
    accepted, rejected = (Decide((2,), d) for d in (Decision.ACCEPTED, Decision.REJECTED))
    back = replay_journal(
        begin(path, accepted, Annotate(2, "x"), UNDO, rejected, UNDO, UNDO, REDO), clip
    )
    assert back.review.state.find(2).decision == Decision.ACCEPTED
    assert back.review.state.find(2).note == SEEN.note
    assert back.review.history == ("Accept interval", "Reject interval")
    assert not back.review.saved
    back.review.undo()
    assert back.review.state.find(2).decision == SEEN.decision
    assert not back.review.saved


def test_a_whole_session_takes_the_place_of_what_was_and_of_all_steps(path):
    other = replace(BEGUN, left_out=((0, 1),))
    back = replay_journal(
        begin(path, Annotate(2, "x"), session_journal_entry(CLIP, other), UNDO), CLIP
    )
    assert (back.entries, back.review.position, back.review.saved) == (3, 0, False)
    assert session_bytes(CLIP, back.review.state) == session_bytes(CLIP, other)


FOREIGN = twist("Tail")
BEHIND = twist(stop=3)  # the clip has two frames
FEWER = {name: TAU[name] for name in BEGUN.tau if name != "RightClavicle"}
CHANGED = {**FEWER, "hip": 0.1}
WITH_LIMBS = {**TAU, "hip": 0.1}
del WITH_LIMBS["RightClavicle"]


@pytest.mark.parametrize(
    ("entry", "known"),
    [
        (Insert(twist()), "all"),
        (Insert(FOREIGN), "none"),
        (Insert(BEHIND), "other clip"),
        (Edit(2, twist(FOREARM)), "all"),
        (Edit(2, twist(FOREARM, stop=3)), "other clip"),
        (Edit(2, FOREIGN), "none"),
        (Edit(9, twist()), "none"),
        (Decide((9,), Decision.ACCEPTED), "none"),
        (Remove(2), "none"),
        (Redetect({ARM: 0.1}, (twist(),)), "all"),
        (Redetect({ARM: 0.1}, (twist(),), "paper"), "all"),
        (Redetect({ARM: 0.1}, (twist(),), "of later"), "all"),  # a detector that is not here
        (Redetect({"Tail": 0.1}, ()), "none"),
        (Redetect({ARM: 0.1}, (twist(), FOREIGN)), "none"),
        (Redetect({ARM: 0.1}, (twist(), BEHIND)), "other clip"),
        (LeaveOut(((0, 2),)), "all"),
        (LeaveOut(((0, 1), (1, 3))), "other clip"),
        (CarryOver((SEEN,)), "all"),
        (CarryOver((SEEN, replace(SEEN, interval=BEHIND))), "other clip"),
        (CarryOver((replace(SEEN, interval=FOREIGN),)), "all"),  # passed over: of another take
        (Settle((SEEN,)), "all"),
        (Settle((replace(SEEN, interval=BEHIND),)), "other clip"),
        (Settle((replace(SEEN, interval=FOREIGN),)), "none"),
        (ChangeChains(RIG, CHANGED, (ARM,), (twist(),)), "all"),
        (ChangeChains(RIG, WITH_LIMBS, (LIMB,), (flip(),)), "all"),
        (ChangeChains(RIG, FEWER, (), ()), "other clip"),
        (ChangeChains(RIG, {**CHANGED, "Tail": 0.1}, (), ()), "other clip"),
        (ChangeChains(Rig(remove=("Tail",)), FEWER, (), ()), "other clip"),
        (ChangeChains(RIG, CHANGED, (ARM,), (BEHIND,)), "other clip"),
        (ChangeChains(RIG, CHANGED, ("Tail",), ()), "none"),
        (Track(TRACKING), "all"),
        (session_journal_entry(CLIP, replace(BEGUN, left_out=((0, 1),))), "all"),
        (session_journal_entry(CLIP, replace(BEGUN, tau={**BEGUN.tau, "Tail": 0.1})), "none"),
        (session_journal_entry(CLIP, replace(BEGUN, intervals=(replace(SEEN, interval=FOREIGN),))),
         "none"),
        (session_journal_entry(CLIP, replace(BEGUN, intervals=(replace(SEEN, interval=BEHIND),))),
         "other clip"),
        (session_journal_entry(CLIP, replace(BEGUN, intervals=(), rig=RIG, tau=CHANGED)), "all"),
        (session_journal_entry(CLIP, replace(BEGUN, intervals=(replace(SEEN, interval=FOREIGN),),
                                             rig=RIG, tau=CHANGED)), "none"),
        (session_journal_entry(CLIP, replace(BEGUN, intervals=(), rig=RIG, tau=FEWER)),
         "other clip"),
        ({"session": 3}, "none"),
        ({"do": "Reconsider"}, "none"),
        ([], "none"),
    ],
)  # fmt: skip
def test_a_line_that_does_not_fit_ends_the_replay(path, entry, known):
    """Frames and chains of the clip are only looked at where it is the journal's own."""
    begin(path, Annotate(1, "before"), entry, REDO)
    for clip in (CLIP, None, OTHER):
        back = replay_journal(path, clip)
        fits = known == "all" or (known == "other clip" and clip is not CLIP)
        assert (back.entries, back.damaged) == ((3, 0) if fits else (1, 2)), clip
        assert back.steps == back.entries
        if not fits:
            assert back.review.state.find(1).note == "before"
        lines = path.read_bytes().splitlines(keepends=True)
        assert back.size == sum(map(len, lines[: back.entries + 1]))


def test_behind_other_chains_what_names_them_fits(path):
    """Each line is looked at in the review as the lines before have left it."""
    back = replay_journal(
        begin(path, ChangeChains(RIG, CHANGED, (), ()), Insert(twist("hip")), UNDO, UNDO), CLIP
    )
    assert (back.entries, back.damaged) == (4, 0)
    assert back.review.state.rig == AS_FOUND
    again = path.with_name("again")
    begin(
        again,
        Insert(twist()),
        ChangeChains(RIG, CHANGED, (), ()),
        session_journal_entry(CLIP, BEGUN),
    )
    assert replay_journal(again, CLIP).damaged == 0


def test_a_damaged_first_line_is_no_journal(path):
    begin(path)
    head = json.loads(path.read_bytes())
    for damage in (
        {**head, "schema": "twistcore.journal/2"},
        {k: v for k, v in head.items() if k != "schema"},
        {k: v for k, v in head.items() if k != "session"},
        {**head, "session": {}},
        {**head, "steps": -1},
        {**head, "steps": "4"},
        [],
    ):
        path.write_text(json.dumps(damage) + "\n")
        with refused(FormatError, f"{path}: "):
            replay_journal(path)
    for data in (b"", b"{", json.dumps(head).encode()):  # no whole line
        path.write_bytes(data)
        with refused(FormatError, f"{path}: "):
            replay_journal(path)
    del head["steps"]  # which the first journals did not have
    path.write_text(json.dumps(head) + "\n")
    assert (
        replay_journal(path).steps,
        replay_journal(path).entries,
        replay_journal(path).damaged,
    ) == (0, 0, 0)
    with pytest.raises(TwistError, match="cannot be read"):
        replay_journal(path.with_name("none"))


# -- the file --------------------------------------------------------------------------------------


class Disk:
    """A file that takes so many bytes at once, and so many in all."""

    def __init__(self, file, at_once, room):
        self.file, self.at_once, self.room = file, at_once, room

    def write(self, data):
        if not self.room:
            raise OSError(28, "full")
        n = self.file.write(data[: min(self.at_once, self.room)])
        self.room -= n
        return n

    def __getattr__(self, name):
        return getattr(self.file, name)


def test_a_disk_that_takes_a_part_at_a_time_gets_all(path):
    with closing(Journal(path, CLIP, BEGUN)) as journal:
        journal._file = Disk(journal._file, 7, 10**6)
        journal.do(Annotate(1, "x" * 100))
    assert replay_journal(path).review.state.find(1).note == "x" * 100


def test_a_line_that_finds_no_room_is_cut_off_and_waits(path):
    with closing(Journal(path, CLIP, BEGUN)) as journal:
        good, file = path.read_bytes(), journal._file
        journal._file = Disk(file, 7, 20)
        for n in (1, 2):
            with pytest.raises(OSError, match="full"):
                journal.do(Annotate(1, f"note {n}"))
            assert (journal.waiting, path.read_bytes()) == (n, good)
        journal._file = file
        journal.do(Annotate(1, "note 3"))
        assert journal.waiting == 0
        whole = path.read_bytes()
        journal.write_waiting()  # nothing waits: nothing is written
        assert path.read_bytes() == whole
    assert whole.startswith(good)
    assert len(replay_journal(path).review.history) == 3


def test_a_closed_journal_takes_nothing_and_is_not_there(path):
    journal = Journal(path, CLIP, BEGUN)
    assert journal.is_there()
    journal.close()
    assert not journal.is_there()
    with pytest.raises(OSError, match="closed"):
        journal.do(Remove(1))
    assert journal.waiting == 1
    journal.discard()  # it may be another's by now
    assert path.exists()


def test_a_journal_that_is_given_up_is_deleted(path):
    journal = Journal(path, CLIP, BEGUN)
    journal.discard()
    assert not path.exists()
    journal.discard()
    moved = Journal(path, CLIP, BEGUN)
    path.rename(path.with_name("moved"))
    assert not moved.is_there()
    moved.discard()
    assert path.with_name("moved").exists()


def test_a_journal_that_cannot_begin_leaves_nothing(path, monkeypatch):
    for name in ("os.fsync", "twistcore.review.journal.sync_folder"):
        with monkeypatch.context() as patch:
            patch.setattr(name, lambda _: (_ for _ in ()).throw(OSError(5, "broken")))
            with pytest.raises(OSError, match="broken"):
                Journal(path, CLIP, BEGUN)
        assert not path.exists()
    begin(path)
    before = path.read_bytes()
    with pytest.raises(FileExistsError):
        Journal(path, CLIP, BEGUN)
    assert path.read_bytes() == before


def test_what_a_disk_refuses_at_the_end_is_no_error(path, monkeypatch):
    def refuse(*_):
        raise OSError(5, "broken")

    journal = Journal(path, CLIP, BEGUN)
    file, journal._file = journal._file, Disk(journal._file, 7, 0)
    journal._file.truncate = journal._file.close = refuse
    with pytest.raises(OSError, match="full"):
        journal.do(Remove(1))
    monkeypatch.setattr("pathlib.Path.unlink", refuse)
    journal.discard()
    file.close()
    assert replay_journal(path).entries == 0


@pytest.mark.skipif(os.name != "posix", reason="elsewhere a locked file cannot be looked at so")
def test_an_open_journal_is_held_also_where_it_is_gone_on_with(path):
    with closing(Journal(path, CLIP, BEGUN)):
        assert is_file_locked(path)
    assert not is_file_locked(path)
    with closing(Journal.resume(replay_journal(path))):
        assert is_file_locked(path)
    assert not is_file_locked(path)


def test_going_on_cuts_what_is_damaged_and_puts_the_whole_beside(path):
    begin(path, Annotate(1, "good"), {"do": "Reconsider"}, Annotate(1, "after"))
    whole, back = path.read_bytes(), replay_journal(path)
    assert back.damaged == 2
    journal = Journal.resume(back)
    assert (journal.path, journal.waiting, path.read_bytes()) == (path, 0, whole[: back.size])
    assert path.with_name(f"{path.name}.damaged").read_bytes() == whole
    journal.do(Annotate(1, "more"))
    assert journal.is_there()
    line = json.dumps(review_command_to_json(Annotate(1, "more"))).encode() + b"\n"
    assert path.read_bytes() == whole[: back.size] + line  # before it is closed, too
    journal.close()
    again = replay_journal(path)
    assert (again.entries, again.damaged, again.review.state.find(1).note) == (2, 0, "more")
    Journal.resume(again).close()
    assert [p.name for p in sorted(path.parent.iterdir())] == [path.name, f"{path.name}.damaged"]


def test_going_on_where_the_folder_takes_no_new_file_uses_the_old_one(path, monkeypatch):
    begin(path, Annotate(1, "good"))
    good = path.read_bytes()
    path.write_bytes(good + b'{"do": "Anno')
    back = replay_journal(path)

    def refuse(*_):
        raise OSError(13, "read-only folder")

    monkeypatch.setattr("twistcore.review.journal.write_atomically", refuse)
    journal = Journal.resume(back)
    assert path.read_bytes() == good
    journal.do(Annotate(1, "more"))
    if os.name == "posix":
        with pytest.raises(OSError, match="read-only folder"):  # it is another window's
            Journal.resume(back)
    journal.close()
    assert replay_journal(path).entries == 2


def test_a_session_in_a_journal_is_the_session_s_document():
    assert session_journal_entry(CLIP, BEGUN) == {"session": session_document(CLIP, BEGUN)}
