"""SMPL poses in pickled, NPZ and JSON files: reading them as a clip."""
