"""The main window: the table of actions, the functions that the actions call, and all dialogs."""
