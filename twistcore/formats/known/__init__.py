"""The registered clip formats. Each module registers one format."""
