"""Which matches are played: blocks of seats and seeds, in batches; nothing here plays."""
