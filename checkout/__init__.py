"""The implementation of `dev.py`, which sets up, starts and tests the program in a checkout.

These modules use only the standard library, because nothing else may be installed yet. They are not
part of the wheel.
"""
