"""Playing a plan: runner, on what executors have to offer."""
