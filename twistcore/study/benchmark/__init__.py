"""Compare the detectors with other common methods on clips with known errors."""
