"""The document that is open in the window, and its settings, files, export and playback."""
