"""The program's detectors, a file each: its name is the detector's, its DETECTOR the detector."""
