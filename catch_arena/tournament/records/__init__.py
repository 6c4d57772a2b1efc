"""What is kept of a tournament, and written from it: store, logs, exports, standings."""
