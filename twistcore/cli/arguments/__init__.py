"""The words of every command, without loading what carries them out: no numpy, no scipy."""
