"""General-purpose widgets that do not depend on anything about twist."""
