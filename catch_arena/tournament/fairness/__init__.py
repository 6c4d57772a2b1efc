"""Is the arena fair? The audit."""
