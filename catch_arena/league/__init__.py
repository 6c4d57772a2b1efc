"""A league, which goes on for a term: one entry for each person, in versions that are placed on a ladder as they come.

- `entries`: the entries in the league's folder, and copies of their files
- `store`: the store of the league, with versions of the entries and their ratings over time
- `matchmaking`: ratings from the newest matches, and the next blocks of matches for entries without a clear place
- `kept_matches`: the matches of an entrant that its page plays, and whose replays stay
- `update`: one run of the league: check what is new, play, rate, and remove what is old
- `site`: the static pages
"""
