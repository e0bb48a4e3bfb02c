"""Twist Inspector, the desktop program that uses twistcore."""
