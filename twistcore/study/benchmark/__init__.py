"""Compare the detectors with common alternatives on clips with known errors."""
