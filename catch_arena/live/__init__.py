"""Matches in a window while they are played: a person in a seat, or agents alone.

`user_input` maps keys and gamepads to commands, `overlays` draws texts over the arena, and `match_window` is the
window. `session` plays, with the person as one of the policies; the window answers its user while agents are slow.
"""
