"""Matches in a window while they are played: a person in a seat, or agents alone.

`user_input` says what keys and gamepads mean, `overlays` are what is written over the arena, `match_window` is the
window, and `session` plays, with the person as one of the policies. `patient_players` asks the agents, which may take
long, while the window answers its user.
"""
