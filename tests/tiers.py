"""The two tiers of tests: the quick ones, and those marked `thorough` (see CONTRIBUTING.md)."""

import pytest
from hypothesis import settings

_PATIENT = 100  # examples of a property that names no number, in the profile "patient"


def examples(number):
    """How many examples a property gets: `number`, and a quarter of it in the quick profile."""
    return max(min(number, 5), number * settings().max_examples // _PATIENT)


def quick(*cases, thorough=()):
    """Cases of `parametrize`: the quick ones and those that only a thorough run takes."""
    return [*cases, *(_thorough(case) for case in thorough)]


def first_quick(cases, number=1):
    """All cases of `parametrize`, the first of which are quick and the others thorough."""
    cases = list(cases)
    return quick(*cases[:number], thorough=cases[number:])


def _thorough(case):
    if isinstance(case, type(pytest.param())):
        return pytest.param(*case.values, id=case.id, marks=[*case.marks, pytest.mark.thorough])
    values = case if isinstance(case, tuple) else (case,)
    return pytest.param(*values, marks=pytest.mark.thorough)
