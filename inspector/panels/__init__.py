"""The panels for reviewing: tables, filters, playback controls and details of an interval."""
