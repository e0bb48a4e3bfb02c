"""What names of joints are understood as."""

import pytest

from tests.twistcore.name_families import FAMILIES
from twistcore.chain import find_chains
from twistcore.joint_names import understood

SIDES = ("Left", "Right")


def test_there_are_sixty_families_each_with_its_source():
    assert len(FAMILIES) >= 60
    assert len({family.name for family in FAMILIES}) == len(FAMILIES)
    assert all(len(family.entry["source"]) > 10 for family in FAMILIES)


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_the_roles_of_a_name_family(family):
    names = list(family.parents())
    found = dict(zip(names, understood(names), strict=True))
    for side, label in enumerate(SIDES):
        for role, pieces in family.limb(side).items():
            first, *others = (found[name] for name in pieces)
            assert (first.side, first.other) == (label, False), pieces
            last = found[pieces[-1]]
            if role not in family.entry.get("from_hierarchy", ()):
                assert any(role in name.roles for name in (first, *others)), (pieces, first)
            assert not last.other
    limb = {name for side in (0, 1) for pieces in family.limb(side).values() for name in pieces}
    for name, parent in family.parents().items():
        if name not in limb and parent is not None:
            joint = found[name]
            assert (
                joint.other
                or joint.helper
                or joint.trunk
                or not joint.roles
                or (
                    joint.roles[0]
                    in ("hand", "toe")  # SMPL's hand below the wrist, toes beside toes
                )
            ), joint


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_the_chains_of_a_name_family(family):
    chains = find_chains(family.motion())
    assert [(c.side, c.segment, c.name) for c in chains if c.ends] == family.chains()
    assert len(family.chains()) == 10 - 2 * len(family.entry.get("lacks", {}))
