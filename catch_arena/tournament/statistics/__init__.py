"""What the results say about the entrants, and how sure that is (docs/ratings.md): arrays in, figures out."""
