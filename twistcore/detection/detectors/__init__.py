"""The program's detectors: one file each, named after the detector, whose constant is DETECTOR."""
