"""The default detector. It measures the twist of parent and child in opposite directions."""
