"""What `benchmarks.branch_coverage` says of what was measured."""

import pytest

from benchmarks.branch_coverage import tell


def summary(statements, lines, branches, gone):
    return {
        "num_statements": statements,
        "covered_lines": lines,
        "num_branches": branches,
        "covered_branches": gone,
    }


@pytest.mark.parametrize(("gone", "status"), [(18, 1), (19, 0)])
def test_each_package_has_its_share(capsys, gone, status):
    files = {
        "twistcore/a.py": summary(80, 76, 20, gone),
        "inspector/b.py": summary(50, 44, 50, 44),
    }
    assert tell(files) == status
    said = capsys.readouterr().out.splitlines()
    assert said[-1] == f"twistcore: {76 + gone}.0 % of 100; of its branches {5 * gone}.0 %"
    assert said[-2] == "inspector: 88.0 % of 100; of its branches 88.0 %"
    assert said[0] == "inspector/b.py: 12 of 100 not covered"


def test_a_package_that_is_not_measured_has_no_share():
    assert tell({"twistcore/a.py": summary(1, 1, 2, 2)}) == 1
