"""The open document: settings, opening and saving, detection, export and playback."""
