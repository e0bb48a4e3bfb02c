"""General-purpose widgets that know nothing about twist."""
