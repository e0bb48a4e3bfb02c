"""The main window: its table of actions, the implementations of these actions, and the dialogs."""
