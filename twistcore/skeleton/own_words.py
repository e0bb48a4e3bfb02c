"""Apply the user's words for joints, which come from `--joint-names`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from twistcore.skeleton.joint_names import changed_joint_name_meanings, vocabulary_with_user_words
from twistcore.skeleton.motion import Motion
from twistcore.skeleton.people import find_people
from twistcore.skeleton.rig import Rig


def add_user_joint_words(rig: Rig, motion: Motion, words: Mapping[str, Any] | None) -> Rig:
    """Add the user's words for joints to a rig, and return the new rig.

    Names in the rig have priority. `words` is the result of
    :func:`twistcore.skeleton.joint_names.read_joint_vocabulary_file`, or None if the user has no
    such words.
    """
    if words is None:
        return rig
    vocabulary, every = vocabulary_with_user_words(words), motion.skeleton.names
    names = {
        j: said
        for j, said in changed_joint_name_meanings(every, vocabulary).items()
        if j in vocabulary.joints
    }
    for person in find_people(motion.skeleton):
        said = changed_joint_name_meanings(person.words, vocabulary)
        of_person = zip(person.joints, person.words, strict=True)
        names |= {every[joint]: said[word] for joint, word in of_person if word in said}
    return rig.with_names({**names, **rig.names})
