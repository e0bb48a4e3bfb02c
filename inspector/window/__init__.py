"""The main window: the one table of actions, what they do, and the dialogs around it."""
