"""The main window: its table of actions, what the actions do, and the dialogs."""
