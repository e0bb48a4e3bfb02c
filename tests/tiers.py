"""The two tiers of tests: the quick ones, and those marked `thorough` (see CONTRIBUTING.md)."""

import pytest
from hypothesis import settings

_PATIENT = 100  # examples of a property that names no number, in the profile "patient"


def examples(number):
    """How many examples a property gets: `number`, and a quarter of it in the quick profile."""
    return max(min(number, 5), number * settings().max_examples // _PATIENT)


def parametrize(names, cases, quick=1, **more):
    """pytest's mark of that name, of which only the first cases are quick; quick: how many."""
    several = not isinstance(names, str) or "," in names
    cases = list(cases)
    late = [_thorough(case, several) for case in cases[quick:]]
    return pytest.mark.parametrize(names, [*cases[:quick], *late], **more)


def _thorough(case, several):
    if isinstance(case, type(pytest.param())):
        return pytest.param(*case.values, id=case.id, marks=[*case.marks, pytest.mark.thorough])
    return pytest.param(*(case if several else (case,)), marks=pytest.mark.thorough)
