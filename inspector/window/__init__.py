"""The main window, with its table of actions, their implementations, and the dialogs."""
