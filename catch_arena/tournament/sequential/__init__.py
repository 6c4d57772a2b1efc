"""Playing until it is known: tests that look while matches are played."""
