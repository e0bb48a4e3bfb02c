"""Compare the detectors with common alternative methods on clips with known errors."""
