"""Tournaments: who plays (entrants), what is played (schedule), one match (match), all of them (runner), what came out (standings, results)."""
