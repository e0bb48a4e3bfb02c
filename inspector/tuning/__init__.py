"""The tuning tab: what every τ costs this clip, suggestions, profiles."""
