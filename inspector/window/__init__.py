"""The main window: the table of actions, the functions that they call, and all dialogs."""
