"""The built-in detectors: one file each, named after the detector, with the constant DETECTOR."""
