"""What the matches say about the entrants, and how sure that is (docs/ratings.md)."""
