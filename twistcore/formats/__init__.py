"""Read, rewrite and write clips. Each file format has a subpackage: BVH, AMC, NPZ, SMPL poses."""
