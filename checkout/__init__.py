"""What `dev.py` does in a checkout: set up, start, test. Only the standard library is used here.

Nothing else is there when it begins; nothing of it is in a wheel.
"""
