"""The open document: settings, opening and saving, proposed intervals, export and playing."""
