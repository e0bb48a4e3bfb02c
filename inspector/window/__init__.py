"""The main window: its table of actions, their implementations, and all dialogs."""
