"""The implementation of `dev.py`: set up, start and test the program in a checkout.

These modules use only the standard library, because nothing else may be installed yet. They are not
part of the wheel.
"""
