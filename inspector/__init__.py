"""Twist Inspector, the desktop program around twistcore."""
