"""A review to try commands on: the walk with eight errors, by the paper's detector."""

import numpy as np

from tests.conftest import ASSETS
from twistcore.analysis import detect
from twistcore.bvh import read_bvh
from twistcore.chain import find_chains
from twistcore.review import Review, start_review

CLIP = read_bvh(ASSETS / "walk_injected.bvh")
CHAINS = find_chains(CLIP.motion)
TAU = {c.name: np.radians(5.0) for c in CHAINS}


def fresh():
    found = detect(CLIP.motion, CHAINS, tau_radians=TAU)
    return Review(start_review("paper", TAU, found, [c.name for c in CHAINS]))
